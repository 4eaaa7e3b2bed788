// Builds report.html as one file. Its content security policy allows only the page's own script, by its hash.
import { createHash } from 'node:crypto';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { defineConfig } from 'vite';

const MARKER = 'SWEEPSTAKE_DOCUMENTS';

function policyFor(script) {
  const hash = createHash('sha256').update(script).digest('base64');
  return `default-src 'none'; script-src 'sha256-${hash}'; style-src 'unsafe-inline'; img-src data:`;
}

function singleFile() {
  return {
    name: 'single-file',
    enforce: 'post',
    apply: 'build',
    generateBundle(_options, bundle) {
      const files = Object.values(bundle);
      const page = files.find((file) => file.fileName.endsWith('.html'));
      const script = files.find((file) => file.type === 'chunk');
      const style = files.find((file) => file.fileName.endsWith('.css'));
      const code = script.code.trim().replaceAll('</script', '<\\/script');
      page.source = page.source
        .replace(/<script type="module"[^>]*><\/script>/, '')
        .replace(/<link rel="stylesheet"[^>]*>/, () => `<style>${style.source}</style>`)
        .replace('<meta charset="utf-8">', (tag) =>
          `${tag}\n<meta http-equiv="Content-Security-Policy" content="${policyFor(code)}">`)
        .replace('</body>', () => `<script type="module">${code}</script>\n</body>`);
      delete bundle[script.fileName];
      delete bundle[style.fileName];
    },
  };
}

// The development server shows the documents named in REPORT (separated by commas), else the samples.
function sampleDocuments() {
  const files = () => process.env.REPORT?.split(',')
    ?? readdirSync('samples').filter((name) => name.endsWith('.json')).map((name) => `samples/${name}`);
  const documents = () => files().filter(existsSync).map((file) => readFileSync(file, 'utf8'));
  return {
    name: 'sample-documents',
    apply: 'serve',
    transformIndexHtml: (page) =>
      page.replace(MARKER, () => `[${documents().join(',')}]`.replaceAll('<', '\\u003c')),
  };
}

export default defineConfig({
  plugins: [sampleDocuments(), singleFile()],
  build: {
    target: 'es2022',
    modulePreload: false,
    assetsInlineLimit: 1e6,
    rollupOptions: { input: 'report.html' },
  },
  // The numbers, colours and theme are the dashboard's own files.
  server: { fs: { allow: ['.', '../tests/report', '../../../server/dashboard/src'] } },
  test: { include: ['../tests/report/*.test.ts'], globals: true, testTimeout: 60_000, pool: 'threads', isolate: false },
});
