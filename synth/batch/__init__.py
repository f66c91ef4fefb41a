"""Many fits in parallel: on this machine or on a Dask cluster, resumable, with identical output."""
