// Builds index.html and its assets. The names of assets contain a hash of their content. The daemon sends a content security
// policy that allows scripts from the daemon only.
import { defineConfig } from 'vite';

// The development server forwards requests to the daemon at DAEMON. The daemon refuses requests from pages of another origin, so
// the Origin header is removed.
function daemonProxy() {
  const toDaemon = {
    target: process.env.DAEMON ?? 'http://127.0.0.1:7434',
    changeOrigin: true,
    configure: (proxy) => proxy.on('proxyReq', (request) => request.removeHeader('origin')),
  };
  return Object.fromEntries(['/api', '/csv', '/events', '/login', '/logout', '/metrics', '/livez', '/readyz'].map((path) => [path, toDaemon]));
}

// In the built page, URLs begin with "./". The daemon replaces the dot by its setting http_base.
export default defineConfig(({ command }) => ({
  base: command === 'build' ? './' : '/',
  build: {
    target: 'es2022',
    modulePreload: { polyfill: false },
    assetsInlineLimit: 0,
    rollupOptions: { input: 'index.html' },
  },
  server: { proxy: daemonProxy() },
  test: { include: ['src/**/*.test.ts'], testTimeout: 60_000, pool: 'threads', isolate: false },
}));
