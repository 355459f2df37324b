// The page of `tulle view` in a browser, over the real program: watching, holding, editing, for everybody, and how fast.
// node check_page.mjs PLACE TULLE CHROMIUM [PATTERN]      PLACE holds node_modules; pictures and work go there
import fs from 'node:fs';
import { browser, check, pictures, stopAll } from './harness.mjs';
import { makeData } from './make_data.mjs';

const start = Date.now();
fs.rmSync(pictures, { recursive: true, force: true });
fs.mkdirSync(pictures, { recursive: true });
makeData();
console.log(`scenes and runs are made (${((Date.now() - start) / 1000).toFixed(1)} s)`);
const parts = await Promise.all(
  ['watch', 'hold', 'edit', 'access', 'tour', 'rates'].map((name) =>
    import(`./check_${name}.mjs`).catch((problem) => {
      if (problem.code === 'ERR_MODULE_NOT_FOUND') return { checks: {} };
      throw problem;
    }),
  ),
);
let failures = 0,
  count = 0;
for (const { checks } of parts) {
  const found = await check(checks);
  failures += found.failures;
  count += found.count;
}
await browser.close();
stopAll();
console.log(
  `${count - failures} of ${count} checks of the page passed in ${((Date.now() - start) / 1000).toFixed(0)} s; pictures are in ${pictures}`,
);
process.exit(failures ? 1 : 0);
