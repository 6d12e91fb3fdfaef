"""Pages of Markdown: their links, their headings, and the files outside docs/ that they name."""
import html
import os
import pathlib
import re
import shutil
import unicodedata

# Files outside docs/ that are pages of the site; others that a page links to are copied into files/.
OUTSIDE = {"reference/your_engine/README.md": "protocol.md", "CONTRIBUTING.md": "contributing.md",
           "CHANGELOG.md": "changelog.md"}
# Stands for the pages that the program writes: its heading `name` is reference/name.md of the site.
MADE_PAGES = "docs/reference/README.md"
LINK = re.compile(r"(!?\[(?:[^\[\]]|\[[^\]]*\])*\]\()([^()\s]+)(\))")
FENCE = re.compile(r"^( {0,3})(`{3,}|~{3,})")


def prose(text):
    """(line, whether it lies outside blocks of code), line by line."""
    fence = None
    for line in text.splitlines(keepends=True):
        mark = FENCE.match(line)
        if fence is None and mark:
            fence = mark.group(2)
            yield line, False
        elif fence is not None:
            if line.strip().startswith(fence) and not line.strip().strip(fence[0]):
                fence = None
            yield line, False
        else:
            yield line, True


def outside_code(text):
    """The text with blocks and spans of code blanked, places kept."""
    blank = "".join(line if plain else re.sub(r"[^\n]", " ", line) for line, plain in prose(text))
    span = r"(`+)(?!`)((?:(?!\n\n).)+?)(?<!`)\1(?!`)"
    return re.sub(span, lambda m: re.sub(r"[^\n]", "x", m.group(0)), blank, flags=re.S)


def links(text):
    """(place in the text, target) of every link and picture outside code. A link's words may hold code."""
    hidden = outside_code(text)
    for found in LINK.finditer(hidden):
        yield found.start(2), text[found.start(2):found.end(2)]


def for_mkdocs(text):
    """In tables, GitHub wants a bar within code escaped; Python-Markdown wants it as it is."""
    span = re.compile(r"`[^`]*`")
    return "".join(span.sub(lambda m: m.group(0).replace("\\|", "|"), line) if plain and line.startswith("|") else line
                   for line, plain in prose(text))


def anchors(text):
    """The ids of a page's headings, as Python-Markdown's table of contents makes them, and ids written out."""
    found, counts = set(), {}
    for line, plain in prose(text):
        heading = re.match(r"#{1,6} +(.*?)(?: +#+)? *$", line) if plain else None
        if heading:
            words = re.sub(r"\{[:#].*\}$", "", heading.group(1))
            words = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", words.replace("`", "").replace("*", ""))
            words = unicodedata.normalize("NFKD", html.unescape(words)).encode("ascii", "ignore").decode()
            slug = re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", words).strip().lower())
            counts[slug] = counts.get(slug, -1) + 1
            found.add(slug if counts[slug] == 0 else f"{slug}_{counts[slug]}")
        if plain:
            found.update(a or b for a, b in re.findall(r"\bid=\"([^\"]+)\"|\{ ?#([\w.-]+)", line))
    return found


def is_local(target):
    return not re.match(r"[a-z][a-z0-9+.-]*:", target) and not target.startswith("//")


def broken_links(folder, pages=None):
    """What is wrong with the relative links of the pages under `folder`: files and headings that do not exist."""
    faults = []
    for page in sorted(pages or folder.rglob("*.md")):
        text = page.read_text(encoding="utf-8")
        for place, target in links(text):
            if not is_local(target):
                continue
            path, _, anchor = target.partition("#")
            file = page.parent / path if path else page
            where = f"{page.relative_to(folder)}:{text.count(chr(10), 0, place) + 1}: {target}"
            if not file.is_file():
                faults.append(f"{where}: no such file")
            elif anchor and file.suffix == ".md" and anchor not in anchors(file.read_text(encoding="utf-8")):
                faults.append(f"{where}: no such heading")
    return faults


def bring_in(root, docs):
    """Copies into `docs` what its pages link to outside the project's docs/, and points the links there. `docs` is a
    copy of root/docs with the program's pages beside. Answers the links that lead nowhere."""
    faults, homes = [], {page: page.relative_to(docs) for page in docs.rglob("*.md")}
    origins = {page: root / "docs" / at for page, at in homes.items()}  # where the page's own links start
    for source, name in OUTSIDE.items():
        if (root / source).is_file():
            shutil.copy(root / source, docs / name)
            origins[docs / name] = root / source
    for page, origin in sorted(origins.items()):
        text, out, last = page.read_text(encoding="utf-8"), [], 0
        for place, target in links(text):
            path, hash_, anchor = target.partition("#")
            if not path or not is_local(target):
                continue
            wanted = pathlib.Path(os.path.normpath(origin.parent / path))
            inside = os.path.relpath(wanted, root)
            if inside == MADE_PAGES:
                home, hash_, anchor = docs / "reference" / f"{anchor}.md", "", ""
            elif inside.startswith("docs" + os.sep):
                home = docs / os.path.relpath(wanted, root / "docs")
            elif inside in OUTSIDE and wanted.is_file():
                home = docs / OUTSIDE[inside]
            elif wanted.is_file() and not inside.startswith(".."):
                home = docs / "files" / inside
                home.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(wanted, home)
            else:
                faults.append(f"{os.path.relpath(origin, root)}: {target}: no such file")
                continue
            out += [text[last:place], os.path.relpath(home, page.parent) + hash_ + anchor]
            last = place + len(target)
        page.write_text(for_mkdocs("".join(out) + text[last:]), encoding="utf-8")
    return faults
