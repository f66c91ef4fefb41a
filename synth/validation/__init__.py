"""E. Krnacik's thesis gone through again, on the laboratory's own recordings: published numbers beside ours."""
