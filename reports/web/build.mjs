// Bundles src/ into dist/: report.js and report.css, pages.js, player.js and player.css. Same sources and lockfile, same bytes.
import { build } from 'esbuild';
import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

process.chdir(fileURLToPath(new URL('.', import.meta.url)));
// A library's licence goes with every copy, and every page is a copy.
const licence = (name, folder) => `/*! Includes ${name}.\n${readFileSync(`node_modules/${folder}/LICENSE`, 'utf8').trim()}\n*/`;
const common = { bundle: true, minify: true, legalComments: 'inline', charset: 'ascii', target: ['es2022'], logLevel: 'warning' };
const script = { ...common, format: 'iife' };
await build({ ...script, entryPoints: ['src/main.ts'], outfile: 'dist/report.js', banner: { js: licence('uPlot', 'uplot') } });
await build({ ...script, entryPoints: ['src/pages.ts'], outfile: 'dist/pages.js' });
await build({ ...common, entryPoints: ['src/report.css'], outfile: 'dist/report.css' });
await build({ ...script, entryPoints: ['src/player/main.ts'], outfile: 'dist/player.js', banner: { js: licence('three.js', 'three') } });
await build({ ...common, entryPoints: ['src/player/player.css'], outfile: 'dist/player.css' });
