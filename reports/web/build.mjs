// Bundles src/ into dist/report.js and dist/report.css. Same sources and lockfile, same bytes.
import { build } from 'esbuild';
import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

process.chdir(fileURLToPath(new URL('.', import.meta.url)));
// uPlot's licence goes with every copy, and every report is a copy.
const licence = `/*! Includes uPlot.\n${readFileSync('node_modules/uplot/LICENSE', 'utf8').trim()}\n*/`;
const common = { bundle: true, minify: true, legalComments: 'inline', charset: 'ascii', target: ['es2022'], logLevel: 'warning' };
await build({ ...common, entryPoints: ['src/main.ts'], outfile: 'dist/report.js', format: 'iife', banner: { js: licence } });
await build({ ...common, entryPoints: ['src/report.css'], outfile: 'dist/report.css' });
