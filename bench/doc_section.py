#!/usr/bin/env python3
"""Puts generated text between markers of a document, so that a figure is never copied by hand."""


def replace_section(path, name, text):
    """Replaces what stands between <!-- NAME:begin --> and <!-- NAME:end --> in the file."""
    begin, end = f"<!-- {name}:begin -->", f"<!-- {name}:end -->"
    with open(path, encoding="utf-8") as file:
        old = file.read()
    if begin not in old or end not in old:
        raise SystemExit(f"{path}: has no markers {begin} and {end}; add them where it belongs")
    head, tail = old.split(begin)[0], old.split(end, 1)[1]
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"{head}{begin}\n{text.strip()}\n{end}{tail}")


def table(head, rows):
    """A Markdown table of strings."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def main():
    import sys
    if len(sys.argv) != 3:
        print("usage: ... | doc_section.py DOCUMENT NAME", file=sys.stderr)
        return 2
    text = sys.stdin.read()
    if not text.strip():
        print("doc_section.py: nothing on standard input; the section is left as it is",
              file=sys.stderr)
        return 1
    replace_section(sys.argv[1], sys.argv[2], text)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
