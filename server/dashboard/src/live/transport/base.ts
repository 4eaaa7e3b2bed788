// The path under which a proxy serves the daemon (setting http_base), such as "/sweepstake"; empty if the daemon is at the root. The daemon
// writes it into index.html.
const content = typeof document === 'undefined' ? undefined : document.querySelector<HTMLMetaElement>('meta[name="base-path"]')?.content;
const BASE = content?.startsWith('/') ? content.slice(0, -1) : '';

// Returns the URL of a path of the daemon, such as "/health".
export const urlOf = (path: string) => BASE + path;

// Inverts urlOf.
export const pathIn = (pathname: string) => (pathname.startsWith(`${BASE}/`) ? pathname.slice(BASE.length) : pathname === BASE ? '/' : pathname);
