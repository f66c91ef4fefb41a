"""The diagnosis of a swinging chain of links."""
