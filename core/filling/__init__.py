"""From cells to the finished quad mesh, and the split that always works."""
