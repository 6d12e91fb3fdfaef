// Atwood's worker protocol (reference/your_engine/README.md): a line in, lines out, until standard input closes.
import { createHash } from "node:crypto";
import { readFileSync, readdirSync, writeSync } from "node:fs";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";
import { askContacts, refuseSweep } from "./contacts.mjs";
import { describeRival, runRival } from "./rival.mjs";
import { Refusal, readScene } from "./scene.mjs";
import { jsonText } from "./settings.mjs";

const BODIES_OF_LINE = 50000;
const EVENTS_OF_LINE = 10000;

/** A number as the protocol writes it: strings where it is not finite. */
const number = (x) => (Number.isFinite(x) ? x : Number.isNaN(x) ? "nan" : x > 0 ? "inf" : "-inf");

/** Writes all of a line to a descriptor; a full pipe is tried again. */
function writeLine(text) {
  let rest = Buffer.from(`${text}\n`);
  while (rest.length > 0) {
    try {
      rest = rest.subarray(writeSync(1, rest));
    } catch (error) {
      if (error.code !== "EAGAIN") throw error;
      Atomics.wait(new Int32Array(new SharedArrayBuffer(4)), 0, 0, 1);
    }
  }
}

function putSample(cell, sample) {
  const { bodies, events, contacts, joints, joint_applied, ropes, t_s } = sample;
  const rows = (list) => list.map((row) => row.map(number));
  for (let from = 0; from === 0 || from < bodies.length; from += BODIES_OF_LINE) {
    const more = from + BODIES_OF_LINE < bodies.length;
    const line = {
      cell,
      t_s,
      ...(from > 0 && { from }),
      bodies: rows(bodies.slice(from, from + BODIES_OF_LINE)),
      ...(more && { more }),
    };
    if (!more)
      Object.assign(
        line,
        joints && { joints: rows(joints) },
        joint_applied && { joint_applied: rows(joint_applied) },
        ropes && { ropes: rows(ropes) },
        contacts && { contacts: rows(contacts) },
        { events: plainEvents(events) },
      );
    writeLine(JSON.stringify(line));
  }
}

const plainEvents = (events) =>
  (events ?? []).map((event) =>
    Object.fromEntries(Object.entries(event).map(([key, x]) => [key, typeof x === "number" ? number(x) : x])),
  );

/** Of Node.js, the engine's files, and these sources: changes whenever the results may. */
function fingerprint(rival) {
  const hash = createHash("sha256").update(process.version);
  const here = fileURLToPath(new URL(".", import.meta.url));
  const sources = [here, rival.folder].flatMap((folder) =>
    readdirSync(folder)
      .filter((name) => name.endsWith(".mjs"))
      .sort()
      .map((name) => join(folder, name)),
  );
  for (const path of [...sources, join(here, "../rivals/tuned.json"), ...rival.files]) hash.update(readFileSync(path));
  return hash.digest("hex");
}

function answerRun(rival, request) {
  return runRival(rival, request, (sample) => putSample(request.cell, sample));
}

async function answerContacts(rival, request) {
  const { contacts } = await askContacts(rival, request);
  writeLine(JSON.stringify({ cell: request.cell, contacts: contacts.map((row) => row.map(number)) }));
  return { status: "ok", reason: "", steps_taken: 0, busy_ns: [] };
}

async function answer(rival, line) {
  let request = {};
  try {
    request = JSON.parse(line);
    if (request.request === "hello") {
      writeLine(jsonText({ protocol: 1, ...describeRival(rival), fingerprint: fingerprint(rival) }));
      return;
    }
    const answers = { run: answerRun, contacts: answerContacts, "contacts-sweep": refuseSweep };
    if (!answers[request.request])
      throw new Refusal(`${rival.name} answers hello, run and contacts; found the request \`${request.request}\``);
    const done = await answers[request.request](rival, request);
    const { events: all, ...rest } = done,
      events = plainEvents(all),
      cell = request.cell;
    while (events.length > EVENTS_OF_LINE)
      writeLine(JSON.stringify({ cell, more: true, events: events.splice(0, EVENTS_OF_LINE) }));
    writeLine(JSON.stringify({ cell, ...(events.length > 0 && { events }), done: rest }));
  } catch (error) {
    const refused = error instanceof Refusal;
    if (!refused) process.stderr.write(`${error?.stack ?? error}\n`);
    const reason = refused ? error.message : `${error?.name ?? "error"}: ${error?.message ?? error}`.replace(/\s+/g, " ");
    writeLine(
      JSON.stringify({
        cell: request.cell ?? -1,
        done: { status: refused ? "unsupported" : "crashed", reason, busy_ns: [], steps_taken: 0 },
      }),
    );
  }
}

/** Answers requests to a rival (rival.mjs; `folder`: that of its sources) until standard input closes. */
export async function serve(rival) {
  for (const name of ["log", "info", "debug"]) console[name] = console.error; // what an engine prints is no answer
  for await (const line of createInterface({ input: process.stdin, crlfDelay: Infinity }))
    if (line) await answer(rival, line);
}
