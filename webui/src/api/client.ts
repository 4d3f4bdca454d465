// SPDX-License-Identifier: Apache-2.0
// Requests to the service's API. URLs are relative, so that the panel also works behind a proxy.

/** A refused request, with the service's own message, or a missing answer (status 0). */
export class ApiError extends Error {
  constructor(readonly status: number, message: string, readonly body: unknown = null) {
    super(message);
  }
}

/** Long enough for a slow camera, short enough to report a missing answer soon. */
const PATIENCE_MS = 15_000;
/** For uploads: the file may be large and the network slow. */
const UPLOAD_PATIENCE_MS = 90_000;

/** Messages for errors without a text of their own, for example from a proxy. */
const MEANING: Record<number, string> = {
  401: 'Sign in as admin first', 403: 'This is not allowed', 404: 'The service does not know this address', 413: 'This is too large for the service',
  423: 'The settings are locked during the match', 429: 'Too many requests: wait a moment, then try again',
  502: 'The service cannot be reached', 503: 'The service is busy: try again in a moment', 504: 'The service does not answer: try again in a moment',
};

export const errorText = (body: unknown, status: number): string =>
  typeof body === 'object' && body !== null && 'error' in body ? String(body.error) : MEANING[status] ?? `The service could not do this (error ${status})`;

/**
 * Called when a change is refused because the user must sign in (401) or a match is running (423). Resolves to true if
 * the request should be repeated.
 */
let openDoor: (status: number) => Promise<boolean> = async () => false;
export function onClosedDoor(ask: typeof openDoor): void { openDoor = ask; }

async function send(path: string, init: RequestInit): Promise<Response> {
  try {
    return await fetch(`api/${path}`, { cache: 'no-store', signal: AbortSignal.timeout(PATIENCE_MS), ...init });
  } catch {
    throw new ApiError(0, 'No answer from the service');
  }
}

/** `doors`: status codes for which openDoor is called. */
async function ask(path: string, init: RequestInit, doors = [401, 423]): Promise<Response> {
  let answer = await send(path, init);
  const isChange = init.method !== undefined && init.method !== 'GET' && path !== 'session';
  if (isChange && doors.includes(answer.status) && await openDoor(answer.status)) answer = await send(path, init);
  if (answer.ok) return answer;
  const parsed: unknown = await answer.json().catch(() => null);
  throw new ApiError(answer.status, errorText(parsed, answer.status), parsed);
}

async function request<T>(method: string, path: string, body?: unknown, headers: Record<string, string> = {}, doors?: number[]): Promise<T> {
  // If the request can be forced, the page itself asks for confirmation during a match.
  const mayInsist = typeof body === 'object' && body !== null && 'force' in body;
  const answer = await ask(path, {
    method,
    headers: body === undefined ? headers : { 'Content-Type': 'application/json', ...headers },
    body: body === undefined ? undefined : JSON.stringify(body),
  }, doors ?? (mayInsist ? [401] : undefined));
  return await answer.json().catch(() => null) as T;
}

/** Every method throws ApiError. `path` is the part after "api/". */
export const api = {
  get: <T>(path: string) => request<T>('GET', path),
  post: <T>(path: string, body?: unknown, headers: Record<string, string> = {}) => request<T>('POST', path, body, headers),
  put: <T>(path: string, body?: unknown) => request<T>('PUT', path, body),
  /** Like put, for a form that asks for the password itself and reports a wrong one. */
  putWithPassword: <T>(path: string, body: unknown) => request<T>('PUT', path, body, {}, []),
  /** Previews a change. Opens no dialog for a password or the match lock, because the user pressed no button. */
  tryOut: <T>(path: string, body: unknown) => request<T>('POST', path, body, {}, []),
  patch: <T>(path: string, body: unknown, headers: Record<string, string> = {}) => request<T>('PATCH', path, body, headers),
  delete: <T>(path: string) => request<T>('DELETE', path),
  /** Renders an image for this request. Opens no dialog, because the user pressed no button. */
  image: async (path: string, body: unknown) => (await ask(path, {
    method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(body),
  }, [])).blob(),
  /** Non-JSON answers: an image, a table. */
  blob: async (path: string) => (await ask(path, {})).blob(),
  /** Uploads a file unchanged; `signal` cancels the upload. */
  async upload<T>(path: string, file: Blob, headers: Record<string, string> = {}, signal?: AbortSignal): Promise<T> {
    // AbortSignal.any() is too new for the browsers at some fields.
    const either = new AbortController();
    const end = () => either.abort();
    const timer = setTimeout(end, UPLOAD_PATIENCE_MS);
    signal?.addEventListener('abort', end);
    try {
      signal?.throwIfAborted();
      const answer = await ask(path, { method: 'POST', headers: { 'Content-Type': 'application/octet-stream', ...headers }, body: file, signal: either.signal });
      return await answer.json() as T;
    } finally {
      clearTimeout(timer);
      signal?.removeEventListener('abort', end);
    }
  },
};

/** The error message of anything that was thrown. */
export const messageOf = (error: unknown): string => (error instanceof Error ? error.message : String(error));
