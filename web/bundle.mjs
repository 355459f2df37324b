// Bundles the page of `tulle view` into OUT_DIR, with the licences of what is in it.
// node bundle.mjs OUT_DIR      NODE_PATH leads to the packages
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const here = path.dirname(fileURLToPath(import.meta.url)),
  out = path.resolve(process.argv[2]),
  packages = process.env.NODE_PATH;
const esbuild = createRequire(path.join(packages, 'x'))('esbuild');
const bundle = (banner, write) =>
  esbuild.build({
    entryPoints: { app: path.join(here, 'src/main.ts') },
    outdir: out,
    bundle: true,
    minify: true,
    format: 'iife',
    target: 'es2022',
    legalComments: 'none',
    logLevel: 'warning',
    metafile: true,
    write,
    banner: { js: banner },
    nodePaths: [packages],
    absWorkingDir: here,
    charset: 'utf8',
  });

// The packages of which something is in the bundle.
function findPackages(metafile) {
  const names = Object.keys(metafile.inputs).map((file) => /.*node_modules\/((?:@[^/]+\/)?[^/]+)/.exec(file)?.[1]);
  return [...new Set(names.filter(Boolean))].sort();
}

function readLicence(name) {
  const file = fs.readdirSync(path.join(packages, name)).find((each) => /^licen[cs]e/i.test(each));
  if (!file) throw new Error(`${name} has no licence`);
  return `${name}\n\n${fs
    .readFileSync(path.join(packages, name, file), 'utf8')
    .trim()
    .replaceAll('*/', '* /')}`;
}

const { metafile } = await bundle('', false);
await bundle(`/*\n${findPackages(metafile).map(readLicence).join('\n\n')}\n*/`, true);
for (const name of ['index.html', 'icon.svg']) fs.copyFileSync(path.join(here, 'src', name), path.join(out, name));
