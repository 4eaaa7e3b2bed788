// Runs the type check, the unit tests and the linter of a front end in parallel. The report has no linter. The
// linter needs Node 20.
//
//   node units_test.mjs FOLDER
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { existsSync } from 'node:fs';
import { resolve } from 'node:path';

const folder = resolve(process.argv[2]);
const missing = (name) => !existsSync(resolve(folder, name));
if (missing('node_modules/vitest/vitest.mjs') || (!missing('proto.mjs') && missing('src/gen'))) {
  console.log(`skipped: run \`npm ci\`, and \`npm run proto\` if package.json has it, in ${folder} first`);
  process.exit(process.env.REQUIRE_REPORT_PAGE ? 1 : 77);
}
const run = async (program, ...words) => {
  const [status] = await once(spawn(process.execPath, [resolve(folder, 'node_modules', program), ...words], { cwd: folder, stdio: 'inherit' }), 'close');
  return status;
};
const hasLinter = !missing('.oxlintrc.json') && Number.parseInt(process.versions.node, 10) >= 20;
const lint = !hasLinter ? 0 : run('oxlint/bin/oxlint', '--deny-warnings', 'src');
const statuses = await Promise.all([run('typescript/bin/tsc', '--noEmit'), run('vitest/vitest.mjs', 'run'), lint]);
process.exit(statuses.every((status) => status === 0) ? 0 : 1);
