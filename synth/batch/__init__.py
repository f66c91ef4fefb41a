"""Many fits at once: on this machine's cores or on a Dask cluster, resumable, with the same bytes either way."""
