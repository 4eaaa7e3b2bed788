// Calls of the daemon's RPCs, in the JSON of the protocol's messages. A name in a message is shown as it came: see parts/name.tsx.
import { create, fromJsonString, toJsonString, type DescMethodServerStreaming, type DescMethodUnary, type DescMessage,
  type MessageInitShape, type MessageShape } from '@bufbuild/protobuf';

const TIMEOUT_MS = 10_000;
export const HEADERS: Readonly<Record<string, string>> = { 'Content-Type': 'application/json', 'X-Sweepstake': '1' };

// Why a call failed. `code` is gRPC's name of it, or UNREACHABLE where there was no answer; `reason` that of the protocol's
// ErrorReason, or empty.
export class ApiError extends Error {
  constructor(readonly code: string, readonly reason: string, message: string) {
    super(message);
  }

  get needsLogin(): boolean {
    return this.code === 'UNAUTHENTICATED';
  }

  /** Whether the same question may have an answer later. */
  get mayPass(): boolean {
    return !['INVALID_ARGUMENT', 'NOT_FOUND', 'PERMISSION_DENIED', 'UNAUTHENTICATED'].includes(this.code);
  }
}

interface ErrorBody {
  error?: { code?: string; reason?: string; message?: string };
}

function errorOf(body: ErrorBody | undefined, fallback: string): ApiError {
  const { code = 'UNKNOWN', reason = '', message = '' } = body?.error ?? {};
  return new ApiError(code, reason, message || fallback);
}

export function parseError(text: string, fallback: string): ApiError {
  try {
    return errorOf(JSON.parse(text) as ErrorBody, fallback);
  } catch {
    return new ApiError('UNKNOWN', '', fallback);
  }
}

export async function errorOfResponse(response: Response): Promise<ApiError> {
  return parseError(await response.text(), `the daemon answered ${response.status} ${response.statusText}`);
}

// Everything that is no answer: no connection, a connection that broke, a timeout.
export function asApiError(error: unknown): ApiError {
  if (error instanceof ApiError) return error;
  const timedOut = error instanceof DOMException && error.name === 'TimeoutError';
  return new ApiError('UNREACHABLE', '', timedOut ? 'the daemon does not answer' : 'the daemon cannot be reached');
}

// Sends a request to the daemon. Throws ApiError; cancelling it throws the signal's reason.
export async function send(path: string, init: RequestInit = {}): Promise<Response> {
  try {
    const response = await fetch(path, { ...init, headers: { ...HEADERS, ...init.headers } });
    if (response.ok) return response;
    throw await errorOfResponse(response);
  } catch (error) {
    if (error instanceof DOMException && error.name === 'AbortError') throw error;
    throw asApiError(error);
  }
}

export const pathOf = (method: { parent: { typeName: string }; name: string }) => `${method.parent.typeName}/${method.name}`;

// The request as JSON.
export function jsonOf<Input extends DescMessage>(schema: Input, request: MessageInitShape<Input>): string {
  return toJsonString(schema, create(schema, request));
}

// A newer daemon may send fields that this page does not know.
export function messageOf<Output extends DescMessage>(schema: Output, json: string): MessageShape<Output> {
  try {
    return fromJsonString(schema, json, { ignoreUnknownFields: true });
  } catch {
    throw new ApiError('UNKNOWN', '', 'the daemon sent what this page cannot read; load the page anew, in case the daemon is a newer one');
  }
}

export async function call<Input extends DescMessage, Output extends DescMessage>(
  method: DescMethodUnary<Input, Output>, request: MessageInitShape<Input>,
): Promise<MessageShape<Output>> {
  const body = jsonOf(method.input, request);
  const response = await send(`/api/${pathOf(method)}`, { method: 'POST', body, signal: AbortSignal.timeout(TIMEOUT_MS) });
  return messageOf(method.output, await response.text());
}

// The lines of a text that comes in pieces.
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

// Calls an RPC that answers with a stream which ends. Throws ApiError, after some messages too; the signal's reason if cancelled.
export async function* stream<Input extends DescMessage, Output extends DescMessage>(
  method: DescMethodServerStreaming<Input, Output>, request: MessageInitShape<Input>, signal?: AbortSignal,
): AsyncGenerator<MessageShape<Output>> {
  const init = { method: 'POST', body: jsonOf(method.input, request), ...(signal && { signal }) };
  const response = await send(`/api/${pathOf(method)}`, init);
  for await (const line of linesOf(response.body!)) {
    if (!line.trim()) continue;
    if (line.startsWith('{"error":')) throw parseError(line, 'the answer broke off');
    yield messageOf(method.output, line);
  }
}
