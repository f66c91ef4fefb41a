"""The page's own scripts, and the security policy that allows only these scripts, by the hash of their text."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

from markupsafe import Markup


@dataclass(frozen=True)
class Script:
    """One of our scripts, as it is written into the page."""

    text: Markup
    digest: str


@cache
def script(name: str) -> Script:
    """``static/NAME``: its text, which must not contain ``</script``, and its SHA-256 in the policy's form."""
    text = resources.files("synth.reports").joinpath(f"static/{name}").read_text(encoding="utf-8")
    assert "</script" not in text.lower(), name
    body = f"\n{text}"  # as it stands between the tags
    digest = base64.b64encode(hashlib.sha256(body.encode("utf-8")).digest()).decode("ascii")
    return Script(Markup(body), digest)


def policy(scripts: Sequence[Script]) -> str:
    """The page's Content-Security-Policy: no network, only pictures inside the page, only these scripts."""
    allowed = " ".join(f"'sha256-{each.digest}'" for each in scripts) or "'none'"
    return f"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src {allowed}"


def data_block(content: Any) -> Markup:
    """JSON that is safe inside a page: nothing in it ends a script element or begins a comment."""
    written = json.dumps(content, ensure_ascii=True, separators=(",", ":"), allow_nan=False)
    return Markup(written.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))
