// Bundles src/ into dist/report.js and dist/report.css. Same sources and lockfile, same bytes.
import { build } from 'esbuild';
import { fileURLToPath } from 'node:url';

process.chdir(fileURLToPath(new URL('.', import.meta.url)));
const common = { bundle: true, minify: true, legalComments: 'inline', charset: 'ascii', target: ['es2022'], logLevel: 'warning' };
await build({ ...common, entryPoints: ['src/main.ts'], outfile: 'dist/report.js', format: 'iife' });
await build({ ...common, entryPoints: ['src/report.css'], outfile: 'dist/report.css' });
