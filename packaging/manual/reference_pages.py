"""Pages that the program writes about itself: its lists, descriptions, schemas and help as Markdown."""
import concurrent.futures
import csv
import html
import io
import json
import os
import re
import subprocess

import gallery

# Whether a picture has the path of a truth must not depend on how busy the machine is: the same sources give the same
# pages. These take minutes and are left out; another that takes as long ends the build.
LONG_TRUTHS = {"chain-100"}
LONGEST_TRUTH_S = 900
MADE = ("Made from the program's own answers when the manual is built ({}), and never edited: it says what this "
        "version of the program does.\n\n")
# The catalogue's parts, by the first tag that a scene has.
PARTS = [("fluid", "Fluids"), ("mechanism", "Mechanisms"), ("pile", "Heaps, walls, settling"),
         ("rotation", "Rotating bodies"),
         ("section-b", "Rotating bodies"), ("section-a", "Points and their orbits"), ("response", "Contact"),
         ("contact", "Contact"), ("section-d", "Contact")]
SHOWN = ("Points and their orbits", "Rotating bodies", "Contact", "Heaps, walls, settling", "Mechanisms", "Fluids", "Others")
MOTIONS = ("point-mass", "velocity-dependent", "rotation", "mechanism", "loop")


def ask(program, *words):
    # Help is written for a terminal; one of 110 columns, without colour, whatever this process has.
    environment = {**os.environ, "COLUMNS": "110", "NO_COLOR": "1"}
    return subprocess.run([program, *words], check=True, capture_output=True, text=True, env=environment,
                          stdin=subprocess.DEVNULL).stdout


def cell(text):
    """Words in a cell of a table: as they stand, whatever Markdown would make of them, but for code in backticks."""
    parts = str(text).replace("\n", " ").split("`")
    if len(parts) % 2 == 0:
        parts = ["\\`".join(parts)]
    return "".join(code(part) if i % 2 else re.sub(r"([\\*_|\[\]#])(?!`)", r"\\\1", html.escape(part, quote=False))
                   for i, part in enumerate(parts))


def code(text):
    """A word in a cell as code."""
    return "`" + str(text).replace("|", "\\|") + "`" if text != "" else ""


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head), *("| " + " | ".join(r) + " |" for r in rows)]
    return "\n".join(lines) + "\n"


def anchor(name):
    return re.sub(r"[^\w-]", "-", name).strip("-")


def orders(method):
    return ", ".join(f"{order:g} ({motion})" for motion, order in sorted(method["claimed_order"].items())) or "none"


def value(v):
    return json.dumps(v) if not isinstance(v, str) else v


# ---- methods and settings --------------------------------------------------------------------------------------------

def methods_page(data):
    text = "# Methods\n\n" + MADE.format("`atwood list methods --json`")
    text += ("What each method of Atwood's own engine computes, where it comes from, and the order that it claims for "
             "each class of motion: points under forces of position (`point-mass`), points under forces of velocity "
             "(`velocity-dependent`), rotating bodies (`rotation`) and joints (`mechanism`). The laboratory measures "
             "these claims ([how](../laboratory.md)). `[tol]` marks methods that choose their steps when a tolerance "
             "is given. Formulas: y' = f(t, y) are the equations of motion, y and y_new the state before and after a step of "
             "length h, p and v positions and velocities with v' = a(t, p); maps such as K(h/2) D(h) K(h/2) are applied in the "
             "order in which they are written. [Settings](settings.md) lists what each takes. Methods of other engines depend on what is "
             "installed: `atwood list methods --long`.\n\n")
    own = [m for m in data["methods"] if m["id"].startswith("atwood/")]
    text += table(["method", *(code(motion) for motion in MOTIONS), ""],
                  [[f"[{code(m['id'])}](#{anchor(m['id'])})",
                    *(f"{m['claimed_order'][motion]:g}" if motion in m["claimed_order"] else "-" for motion in MOTIONS),
                    "[tol]" if m["adaptive"] else ""] for m in own]) + "\n"
    for m in own + data["responses"]:
        text += f"## `{m['id']}` {{ #{anchor(m['id'])} }}\n\n{cell(m['doc'])}\n\n"
        if m["formula"]:
            text += f"Formula:\n\n```text\n{m['formula']}\n```\n\n"
        if m in own:
            text += f"Claimed orders: {cell(orders(m))}.\n\n"
        if m["source"]:
            text += f"Source: {cell(m['source'])}.\n\n"
    return text


def settings_page(data):
    text = "# Settings\n\n" + MADE.format("`atwood list methods --json`")
    text += ("Settings stand in a method's id, as in `atwood/rk4{compensated=true}` or "
             "`atwood/rk4+event{restitution=poisson}`. Each setting once, with the methods of Atwood's engine "
             "that have it; `atwood describe METHOD` prints those of any one method, of other engines too.\n\n")
    known = {}
    for m in data["methods"] + data["responses"]:
        if m["id"].startswith(("atwood/", "+")):
            for name, standard in m["settings"].items():
                rule = m["setting_rules"].get(name, {"doc": "", "unit": "", "takes": ""})
                known.setdefault((name, value(standard), rule["doc"], rule["takes"], rule["unit"]), []).append(m["id"])
    count = sum(m["id"].startswith("atwood/") for m in data["methods"])
    rows = []
    for (name, standard, doc, takes, unit), ids in sorted(known.items()):
        whose = f"{len(ids)} of {count} methods" if len(ids) > 4 else ", ".join(code(i) for i in ids)
        rows.append([code(name), code(standard), cell(takes) + (f" \\[{cell(unit)}\\]" if unit else ""), cell(doc),
                     whose])
    return text + table(["setting", "default", "takes", "what it does", "of"], rows)


def metrics_page(data):
    text = "# Metrics\n\n" + MADE.format("`atwood list metrics --json`")
    text += ("What the column `metric` of a row can hold. The unit `1` is that of a ratio or a count. A row's "
             "`truth_bar` bounds the error of the truth behind the value; of an order it is half of its 95 % "
             "interval. Formulas: a star marks the truth, t_k are the instants of the samples. Source: the work that the "
             "measure is taken from, or `here` where the project defines it.\n\n")
    return text + table(["metric", "unit", "definition", "formula", "source"],
                        [[f'<span id="{anchor(m["name"])}"></span>' + code(m["name"]), code(m["unit"]),
                          cell(m["definition"]), code(m["formula"]), cell(m["source"])]
                         for m in data["metrics"]])


def required(gate):
    """What a gate asks for, in words."""
    if "within" in gate:
        return "from {:g} to {:g}".format(*gate["within"])
    if "within_claim" in gate:
        return f"the claimed order ({gate['within_claim']}) within max(0.1, 2 %)"
    if "max_ratio" in gate:
        return f"at most {gate['max_ratio']['value']:g} times that of {gate['max_ratio']['to']}"
    (bound, words), = ((b, w) for b, w in (("max", "at most"), ("min", "at least")) if b in gate)
    return f"{words} {gate[bound]:g}"


def gates_page(data):
    text = "# Gates\n\n" + MADE.format("`atwood list gates --json`")
    text += (f"The {len(data['gates'])} gates of the catalogue: what a run must show, and why. A star stands for any "
             "name. [Gate a CI job](../gates.md) explains verdicts, and how to write gates of your own.\n\n")
    rows = [[code(g["scenario"]), code(g["method"]), code(g["metric"]) +
             (f" at {g['steps']} steps" if "steps" in g else ""), cell(required(g)), cell(g["reason"])]
            for g in data["gates"]]
    return text + table(["scenario", "method", "metric", "must be", "reason"], rows)


# ---- scenes ------------------------------------------------------------------------------------------------------

def true_paths(program, scenario):
    """Positions and orientations of each body along the truth; none where there is none, or it takes minutes."""
    if scenario["scene"].get("fluids") or scenario["truth"]["kind"] == "none" or scenario["id"] in LONG_TRUTHS:
        return []
    ended = subprocess.run([program, "trace", scenario["id"], "--method", "truth", "--limit", str(2 * LONGEST_TRUTH_S)],
                           text=True, capture_output=True, timeout=LONGEST_TRUTH_S)
    if ended.returncode not in (0, 1):  # 1: a truth that ends before the scene does
        raise RuntimeError(f"{scenario['id']}: the truth ended with {ended.returncode}: {ended.stderr}")
    paths = {}
    for row in csv.DictReader(io.StringIO(ended.stdout)):
        place, turn = (tuple(float(row[k]) for k in keys.split()) for keys in ("px_m py_m pz_m", "qw qx qy qz"))
        if all(abs(x) < 1e30 for x in place):
            paths.setdefault(row["body"], []).append((place, turn))
    return list(paths.values())


def scene_entry(program, docs, scene, pictures):
    scenario = json.loads(ask(program, "describe", scene["id"], "--json"))
    drawn = None
    wanted = pictures is True or (pictures and scene["id"] in pictures)
    if wanted and "geometry" not in scene["tags"]:
        drawn = gallery.picture(scene["title"], scenario["scene"], true_paths(program, scenario))
    if drawn:
        (docs / "reference/scenes" / f"{scene['id']}.svg").write_text(drawn, encoding="utf-8")
    title = html.escape(scene["title"])
    picture = f'<img src="scenes/{scene["id"]}.svg" alt="{title}" loading="lazy">' if drawn else ""
    steps = f"{scene['steps'][0]} to {scene['steps'][-1]} steps" if len(scene["steps"]) > 1 else ", ".join(
        f"{n} steps" for n in scene["steps"])
    words = [html.escape(scene["claim"]), f"Truth: {scenario['truth']['kind']}; {scene['t_end_s']:g} s, {steps}."]
    if scenario.get("source"):
        words.append("Source: " + html.escape(scenario["source"]) + ".")
    return (f'<figure id="{anchor(scene["id"])}">{picture}<figcaption><b>{title}</b><br>'
            f"<code>{html.escape(scene['id'])}</code><br>{'<br>'.join(words)}</figcaption></figure>")


def part_of(scene):
    return next((title for tag, title in PARTS if tag in scene["tags"]), "Others")


def scenarios_page(program, docs, data, pictures):
    (docs / "reference/scenes").mkdir(parents=True, exist_ok=True)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        entries = list(pool.map(lambda s: (part_of(s), scene_entry(program, docs, s, pictures)), data["scenarios"]))
    text = "# The catalogue of scenes\n\n" + MADE.format("`atwood list scenarios --json`, `describe`, `trace`")
    text += ("Pictures show shapes at the start (grey: fixed) and the paths of the bodies' centres along the truth; "
             "a view from the front or from above where nothing leaves that plane. Bodies without a shape are drawn as "
             "boxes of their inertia, points as dots, joints as lines from their anchors. A single body that turns on a path "
             "much larger than itself is shown from its own centre, with the path of a point on its longest axis. "
             "`atwood describe ID` says more about each, `atwood play ID` shows it in motion.\n\n")
    for title in SHOWN:
        figures = [figure for part, figure in entries if part == title]
        if figures:
            text += f'## {title}\n\n{len(figures)} scenes.\n\n<div class="gallery">\n'
            text += "\n".join(figures) + "\n</div>\n\n"
    return text


# ---- the program -----------------------------------------------------------------------------------------------------

def exit_codes(program):
    """[(codes, meaning)] from the last sentence of the program's help."""
    footer = " ".join(ask(program, "help").split()).rsplit("Exit codes: ", 1)[1].rstrip(".")
    return [re.match(r"([\d, ]+?) (?=\D)(.*)", piece).groups() for piece in re.split(r"; (?=\d)", footer)]


def exit_codes_page(program):
    rows = [[codes, cell(meaning)] for codes, meaning in exit_codes(program)]
    return ("# Exit codes\n\n" + MADE.format("`atwood help`") + table(["code", "meaning"], rows) +
            "\nA job that must tell a physics failure from a broken run looks for 1 and for 3; [gates](../gates.md) "
            "says which endings of cells lead to which.\n")


def options_page(program):
    text = "# Commands and options\n\n" + MADE.format("`atwood help COMMAND`")
    listed = ask(program, "help").split("Commands:\n", 1)[1].split("\n\n", 1)[0]
    commands = re.findall(r"^  ([a-z]+)(?: |$)", listed, re.M)
    for command in commands:
        shown = ask(program, "help", command).split("Exit codes:")[0].rstrip()
        text += f"## {command}\n\n```text\n{shown}\n```\n\n"
    return text + "See also the [exit codes](exit-codes.md).\n"


def key_rows(schema, prefix="", depth=0):
    """(key, type, meaning) of an object's keys, and of the objects within."""
    for name, key in schema.get("properties", {}).items():
        inner = key.get("items", key)
        kind = key.get("type") or ("one of several" if "oneOf" in key else "shape" if "$ref" in inner else "")
        kind = " or ".join(kind) if isinstance(kind, list) else kind
        needed = " (required)" if name in schema.get("required", []) else ""
        yield [code(prefix + name), cell(kind) + needed, cell(key.get("description", ""))]
        if depth < 2 and isinstance(inner, dict) and "properties" in inner:
            yield from key_rows(inner, prefix + name + ".", depth + 1)


SCHEMAS = [("scenario", "Scenario files", "A scene is a TOML file with these keys; `body.name` is the key `name` of a "
            "`[[body]]`. Kinds of forces, shapes and joints are in the schema itself."),
           ("rows", "Rows", "A row of results, as `-o json:FILE` writes it; `-o csv:FILE` has the same columns.")]


def schema_page(program, docs):
    text = "# Schemas\n\n" + MADE.format("`atwood schema`")
    for name, title, words in SCHEMAS:
        shown = ask(program, "schema", name)
        (docs / f"reference/{name}.schema.json").write_text(shown, encoding="utf-8")
        schema = json.loads(shown)
        text += (f"## {title}\n\n{words} The whole JSON Schema: [{name}.schema.json]({name}.schema.json).\n\n"
                 + table(["key", "type", "meaning"], key_rows(schema)) + "\n")
    return text


def write(program, docs, pictures):
    (docs / "reference").mkdir(parents=True, exist_ok=True)
    data = json.loads(ask(program, "list", "--json"))
    pages = {"methods": methods_page(data), "settings": settings_page(data), "metrics": metrics_page(data),
             "gates": gates_page(data),
             "scenarios": scenarios_page(program, docs, data, pictures), "exit-codes": exit_codes_page(program),
             "options": options_page(program), "schema": schema_page(program, docs)}
    for name, text in pages.items():
        (docs / "reference" / f"{name}.md").write_text(text, encoding="utf-8")
