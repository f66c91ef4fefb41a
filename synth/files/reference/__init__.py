"""The reference of all file formats, made from the schema classes: pages for readers, JSON Schema for editors."""
