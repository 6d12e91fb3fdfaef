"""A report's page around data made by hand: the committed bundle, the data that reports/render would embed."""
import base64
import json
import pathlib
import zlib


class Report:
    """Rows and tables of a small report; figures are added one by one."""

    def __init__(self, title="By hand"):
        self.strings, self.index = [], {}
        self.columns = {name: [] for name in ("scenario", "method", "steps", "h_s", "body", "t_s", "metric", "unit", "value", "truth_bar", "status", "reason", "settings_hash", "engine_version")}
        self.data = {"title": title, "command": "atwood run", "program": "atwood", "left_out": "", "provenance": {"run_id": "2026-01-02T03:04:05Z", "commit": "0123abc"}, "verdicts": [], "laws": [],
                     "scenarios": [], "own_files": {}, "engines": [], "ran": [], "missing_engines": [], "metrics": [], "bench": [], "dominance": [], "goals": [], "notes": [],
                     "series": {"instants": [], "runs": []}}

    def word(self, text):
        if text not in self.index:
            self.index[text] = len(self.strings)
            self.strings.append(text)
        return self.index[text]

    def scene(self, id, title, t_end_s=1.0, steps=(120, 240, 480), metric="", tags=()):
        scene = {"id": id, "title": title, "claim": f"What {id} claims.", "source": "by hand", "truth": "closed form", "t_end_s": t_end_s, "samples": 10, "steps": list(steps), "tags": list(tags), "invariants": []}
        if metric:
            scene["metric"] = metric
        self.data["scenarios"].append(scene)

    def row(self, scenario, method, steps, metric, value, bar=0.0, unit="m", status="ok", reason="", body="", t_end_s=1.0):
        texts = {"scenario": scenario, "method": method, "body": body, "metric": metric, "unit": unit, "status": status, "reason": reason, "settings_hash": "", "engine_version": "1"}
        for name, column in self.columns.items():
            column.append(self.word(texts[name]) if name in texts else {"steps": steps, "h_s": t_end_s / steps if steps else 0, "t_s": None, "value": value, "truth_bar": bar}[name])

    def page(self, web):
        data = {**self.data, "rows": self.columns, "strings": self.strings}
        packer = zlib.compressobj(9, zlib.DEFLATED, -15)
        coded = base64.b64encode(packer.compress(json.dumps(data).encode()) + packer.flush()).decode()
        dist = pathlib.Path(web) / "dist"
        policy = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"
        return (f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><meta http-equiv="Content-Security-Policy" content="{policy}">'
                f'<meta name="viewport" content="width=device-width, initial-scale=1"><title>By hand</title><style>{(dist / "report.css").read_text()}</style></head>\n<body>'
                '<header id="top"><div class="masthead"><h1>By hand</h1><div id="tools"></div></div><section id="verdict" class="pass" aria-label="Verdict"><p class="word">Pass</p></section></header>'
                f'<main id="app"></main><script type="text/plain" id="data">{coded}</script><script>{(dist / "report.js").read_text()}</script></body></html>\n')
