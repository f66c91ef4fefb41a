"""XML trees as text, with any characters in names and comments."""

from __future__ import annotations

from xml.etree.ElementTree import Comment, Element, indent, tostring


def xml_text(root: Element, *, declared: bool = False) -> str:
    """The tree as an indented document, with its declaration if requested; comments are made valid."""
    for node in root.iter():
        if node.tag is Comment:  # type: ignore[comparison-overlap]
            node.text = comment_text(node.text or "")
    indent(root)
    head = '<?xml version="1.0"?>\n' if declared else ""
    return f"{head}{tostring(root, encoding='unicode')}\n"


def comment_text(text: str) -> str:
    """Text without two consecutive hyphens, and none at its end, as XML comments require."""
    while "--" in text:
        text = text.replace("--", "- -")
    return f"{text} " if text.endswith("-") else text


def nested(parent: Element, tag: str, text: str = "", **attributes: str) -> Element:
    """A new child with a text."""
    child = Element(tag, attributes)
    child.text = text or None
    parent.append(child)
    return child
