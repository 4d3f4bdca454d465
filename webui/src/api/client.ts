// SPDX-License-Identifier: Apache-2.0
// Requests to the service's interface. Addresses are relative, so that the panel also works behind a proxy.

/** What the service refused, in its own words, or that it did not answer (status 0). */
export class ApiError extends Error {
  constructor(readonly status: number, message: string, readonly body: unknown = null) {
    super(message);
  }
}

/** Long enough for a camera that is slow to answer, short enough to say that nothing comes. */
const PATIENCE_MS = 15_000;
/** For a file, which may be large and the network slow. */
const UPLOAD_PATIENCE_MS = 90_000;

/** What a refusal means where nobody says it in words: a proxy in between, say. */
const MEANING: Record<number, string> = {
  401: 'Sign in as admin first', 403: 'This is not allowed', 404: 'The service does not know this address', 413: 'This is too large for the service',
  423: 'The settings are locked during the match', 429: 'Too many requests: wait a moment, then try again',
  502: 'The service cannot be reached', 503: 'The service is busy: try again in a moment', 504: 'The service does not answer: try again in a moment',
};

export const errorText = (body: unknown, status: number): string =>
  typeof body === 'object' && body !== null && 'error' in body ? String(body.error) : MEANING[status] ?? `The service could not do this (error ${status})`;

/**
 * Asked when a change is refused because somebody must sign in first (401) or a match runs (423). Says whether it is
 * worth trying again.
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

/** `doors`: refusals about which openDoor is asked. */
async function ask(path: string, init: RequestInit, doors = [401, 423]): Promise<Response> {
  let answer = await send(path, init);
  const isChange = init.method !== undefined && init.method !== 'GET' && path !== 'session';
  if (isChange && doors.includes(answer.status) && await openDoor(answer.status)) answer = await send(path, init);
  if (answer.ok) return answer;
  const parsed: unknown = await answer.json().catch(() => null);
  throw new ApiError(answer.status, errorText(parsed, answer.status), parsed);
}

async function request<T>(method: string, path: string, body?: unknown, headers: Record<string, string> = {}, doors?: number[]): Promise<T> {
  // Where one may insist, the page itself asks whether to do so in a match.
  const mayInsist = typeof body === 'object' && body !== null && 'force' in body;
  const answer = await ask(path, {
    method,
    headers: body === undefined ? headers : { 'Content-Type': 'application/json', ...headers },
    body: body === undefined ? undefined : JSON.stringify(body),
  }, doors ?? (mayInsist ? [401] : undefined));
  return await answer.json().catch(() => null) as T;
}

/** Each throws ApiError. `path` is what follows "api/". */
export const api = {
  get: <T>(path: string) => request<T>('GET', path),
  post: <T>(path: string, body?: unknown, headers: Record<string, string> = {}) => request<T>('POST', path, body, headers),
  put: <T>(path: string, body?: unknown) => request<T>('PUT', path, body),
  /** As put, for a form that asks for the password itself: a wrong one is refused there. */
  putWithPassword: <T>(path: string, body: unknown) => request<T>('PUT', path, body, {}, []),
  /** What a change would do. Asks for no password and no leave: nobody pressed a button for it. */
  tryOut: <T>(path: string, body: unknown) => request<T>('POST', path, body, {}, []),
  patch: <T>(path: string, body: unknown, headers: Record<string, string> = {}) => request<T>('PATCH', path, body, headers),
  delete: <T>(path: string) => request<T>('DELETE', path),
  /** An image that is made for this request. Asks for no password and no leave: nobody pressed a button for it. */
  image: async (path: string, body: unknown) => (await ask(path, {
    method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(body),
  }, [])).blob(),
  /** What is no JSON: an image, a table. */
  blob: async (path: string) => (await ask(path, {})).blob(),
  /** Sends a file as it is; `signal` ends that. */
  async upload<T>(path: string, file: Blob, headers: Record<string, string> = {}, signal?: AbortSignal): Promise<T> {
    // AbortSignal.any() is too young for the browsers of some fields.
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

/** What to tell somebody about whatever was thrown. */
export const messageOf = (error: unknown): string => (error instanceof Error ? error.message : String(error));
