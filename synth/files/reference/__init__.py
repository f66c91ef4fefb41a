"""The reference of all file formats, generated from the schema classes: pages, and JSON Schema for editors."""
