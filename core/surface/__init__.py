"""Triangle surfaces: connectivity, angles, frames; finer ones; places on them."""
