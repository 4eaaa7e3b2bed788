// Builds index.html and its assets, whose names contain a hash of their content. The daemon sends the content security policy, which
// allows scripts from the daemon only.
import { defineConfig } from 'vite';

// The development server asks the daemon at DAEMON, which lets in what comes from its own page only.
function daemonProxy() {
  const toDaemon = {
    target: process.env.DAEMON ?? 'http://127.0.0.1:7434',
    changeOrigin: true,
    configure: (proxy) => proxy.on('proxyReq', (request) => request.removeHeader('origin')),
  };
  return Object.fromEntries(['/api', '/events', '/login', '/logout', '/metrics', '/livez', '/readyz'].map((path) => [path, toDaemon]));
}

export default defineConfig({
  build: {
    target: 'es2022',
    modulePreload: { polyfill: false },
    assetsInlineLimit: 0,
    rollupOptions: { input: 'index.html' },
  },
  server: { proxy: daemonProxy() },
  test: { include: ['src/**/*.test.ts'], testTimeout: 60_000, pool: 'threads', isolate: false },
});
