"""Compiled templates of the pages in the user's cache folder: compiling those of a report takes 0.2 s of a processor.

jinja's own store on disk unmarshals and executes what lies in a folder among the temporary files. Here a file is read
only after ``synth.cache`` has verified it, as compiled equations of motion are.
"""

from __future__ import annotations

import hashlib
import sys
from functools import cache
from pathlib import Path

import jinja2
from jinja2.bccache import Bucket

from synth.cache import own_folder, read_sealed, write_sealed

FOLDER = "templates"


class KeptTemplates(jinja2.BytecodeCache):
    """Each compiled template as one file, whose name holds a hash of everything that its code depends on."""

    def load_bytecode(self, bucket: Bucket) -> None:
        """Fill the bucket, if its template is stored."""
        path = _path(bucket)
        content = None if path is None else read_sealed(path)
        if content is not None:
            bucket.bytecode_from_string(content)

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Store the bucket's template, where the cache folder can be written."""
        path = _path(bucket)
        if path is not None:
            write_sealed(path, bucket.bytecode_to_string())


@cache
def kept_templates() -> KeptTemplates:
    """The one of this process: pages that are given the same share their templates in memory too."""
    return KeptTemplates()


def _path(bucket: Bucket) -> Path | None:
    folder, made_by = own_folder(FOLDER), bucket.environment
    options = made_by.trim_blocks, made_by.lstrip_blocks, made_by.keep_trailing_newline, made_by.autoescape
    depends = bucket.key, bucket.checksum, jinja2.__version__, sys.version, options
    digest = hashlib.sha256(repr(depends).encode()).hexdigest()
    return None if folder is None else folder / digest[:32]
