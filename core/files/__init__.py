"""Files: meshes that come in, block grids for solvers that go out."""
