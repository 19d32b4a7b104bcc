"""Few blocks: arcs of length zero, chords without quads, drafts of layouts compared."""
