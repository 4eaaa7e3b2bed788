// Calls the daemon's RPCs over HTTP, with messages as JSON. Names in messages are not escaped: parts/name.tsx shows them safely.
import { create, fromJsonText, type Init, type Schema, type Streaming, toJsonText, type Unary } from './messages';

// The path under which a proxy serves the daemon (setting http_base), such as "/sweepstake"; empty if the daemon is at the root. The daemon
// writes it into index.html.
const content = typeof document === 'undefined' ? undefined : document.querySelector<HTMLMetaElement>('meta[name="base-path"]')?.content;
const BASE = content?.startsWith('/') ? content.slice(0, -1) : '';

export const urlOf = (path: string) => BASE + path;

export const pathIn = (pathname: string) => (pathname.startsWith(`${BASE}/`) ? pathname.slice(BASE.length) : pathname === BASE ? '/' : pathname);

const TIMEOUT_MS = 10_000;
export const HEADERS: Readonly<Record<string, string>> = { 'Content-Type': 'application/json', 'X-Sweepstake': '1' };

// `code` is the name of gRPC's status code, or UNREACHABLE without an answer. `reason` is the name of an ErrorReason, or empty.
export class ApiError extends Error {
  constructor(readonly code: string, readonly reason: string, message: string) {
    super(message);
  }

  get needsLogin(): boolean {
    return this.code === 'UNAUTHENTICATED';
  }

  /** Whether the same call may succeed later. */
  get mayPass(): boolean {
    return !['INVALID_ARGUMENT', 'NOT_FOUND', 'PERMISSION_DENIED', 'UNAUTHENTICATED'].includes(this.code);
  }
}

export function parseError(text: string, fallback: string): ApiError {
  try {
    const { code = 'UNKNOWN', reason = '', message = '' } = (JSON.parse(text) as { error?: Partial<ApiError> }).error ?? {};
    return new ApiError(code, reason, message || fallback);
  } catch {
    return new ApiError('UNKNOWN', '', fallback);
  }
}

export const errorOfResponse = async (response: Response): Promise<ApiError> =>
  parseError(await response.text(), `the daemon answered ${response.status} ${response.statusText}`);

// Converts any other exception (no connection, a broken connection, a timeout) to an ApiError.
export function asApiError(error: unknown): ApiError {
  if (error instanceof ApiError) return error;
  const timedOut = error instanceof DOMException && error.name === 'TimeoutError';
  return new ApiError('UNREACHABLE', '', timedOut ? 'the daemon does not answer in time' : 'the daemon cannot be reached');
}

// Sends a request to the daemon. Throws ApiError; if cancelled, throws the signal's reason.
export async function send(path: string, init: RequestInit = {}): Promise<Response> {
  try {
    const response = await fetch(urlOf(path), { ...init, headers: { ...HEADERS, ...init.headers } });
    if (response.ok) return response;
    throw await errorOfResponse(response);
  } catch (error) {
    if (error instanceof DOMException && error.name === 'AbortError') throw error;
    throw asApiError(error);
  }
}

export const jsonOf = <Request>(schema: Schema<Request>, request: NoInfer<Init<Request>>) => toJsonText(schema, create(schema, request));

// Reads a message from JSON. Ignores fields that this page does not know, which a newer daemon may send. Throws ApiError.
export function messageOf<Response>(schema: Schema<Response>, json: string): Response {
  try {
    return fromJsonText(schema, json);
  } catch {
    throw new ApiError('UNKNOWN', '', 'this page cannot read the answer of the daemon, which may be a newer version; reload the page');
  }
}

export async function call<Request, Response>(method: Unary<Request, Response>, request: NoInfer<Init<Request>>, cancel?: AbortSignal): Promise<Response> {
  const body = jsonOf(method.input, request);
  const timeout = AbortSignal.timeout(TIMEOUT_MS);
  const response = await send(`/api/${method.path}`, { method: 'POST', body, signal: cancel ? AbortSignal.any([timeout, cancel]) : timeout });
  return messageOf(method.output, await response.text());
}

export async function* linesOf(body: ReadableStream<Uint8Array>): AsyncGenerator<string> {
  const decoder = new TextDecoder();
  const reader = body.getReader();
  let rest = '';
  try {
    for (;;) {
      const { done, value } = await reader.read();
      rest += decoder.decode(value, { stream: !done });
      const lines = rest.split('\n');
      rest = lines.pop()!;
      yield* lines;
      if (done) break;
    }
    if (rest) yield rest;
  } finally {
    await reader.cancel().catch(() => undefined);
  }
}

// Calls an RPC that answers with a finite stream. Throws ApiError, possibly after some messages; if cancelled, the signal's reason.
export async function* stream<Request, Response>(method: Streaming<Request, Response>, request: NoInfer<Init<Request>>, signal?: AbortSignal): AsyncGenerator<Response> {
  const init = { method: 'POST', body: jsonOf(method.input, request), ...(signal && { signal }) };
  const response = await send(`/api/${method.path}`, init);
  for await (const line of linesOf(response.body!)) {
    if (!line.trim()) continue;
    if (line.startsWith('{"error":')) throw parseError(line, 'the daemon ended its answer before it was complete');
    yield messageOf(method.output, line);
  }
}
