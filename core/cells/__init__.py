"""Critical streamlines, and the four-sided cells that they cut the surface into."""
