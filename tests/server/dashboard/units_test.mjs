// Checks the types of the page's sources and runs their unit tests.
import { spawnSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const dashboard = fileURLToPath(new URL('../../../server/dashboard/', import.meta.url));
const modules = `${dashboard}node_modules/`;
if (!existsSync(`${modules}vitest/vitest.mjs`) || !existsSync(`${dashboard}src/gen`)) {
  console.log('skipped: `npm ci` and `npm run proto` in server/dashboard make what these tests need');
  process.exit(process.env.REQUIRE_REPORT_PAGE ? 1 : 77);
}
for (const command of [[`${modules}typescript/bin/tsc`, '--noEmit'], [`${modules}vitest/vitest.mjs`, 'run']]) {
  const { status } = spawnSync(process.execPath, command, { cwd: dashboard, stdio: 'inherit' });
  if (status !== 0) process.exit(1);
}
