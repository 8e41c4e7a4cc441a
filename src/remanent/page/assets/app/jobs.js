// Work that the server does in the background, with progress and cancel, over one socket.

import { Refused, ServerGone, isServerThere, noteConnection } from "./api.js";

/** Status of a refusal because of what is computed for others, and milliseconds to the next try. */
const BUSY = 429;
const AGAIN_MS = 1500;

let socket = null;
let opening = null;
let count = 0;
/** What was asked for, by its number, until it is settled; one at a time is at the server. */
const waiting = new Map();
let current = null;

/**
 * Start a job; it waits until those before it are done.
 * @param {string} job its kind, for example "frequency_response"
 * @param {Object} spec
 * @param {Object} options
 * @param {function(number, string): void} onProgress share from 0 to 1, and what is being done
 * @returns {{result: Promise<Object>, cancel: function(): void}} cancel rejects with AbortError
 */
export function startJob(job, spec, options, onProgress) {
  const message = (id) => JSON.stringify({ id, job, spec, options });
  const begin = (id) => opened().then((open) => waiting.has(id) && open.send(message(id)));
  const { id, result } = enqueued(begin, onProgress);
  return { result, cancel: () => cancel(id) };
}

/**
 * Ask for something that takes the place of a job, when those before it are done.
 * @param {function(): Promise<*>} request
 * @returns {Promise<*>} what it gives
 */
export function inTurn(request) {
  return enqueued(async (id) => settle(id, "resolve", await request()), () => {}).result;
}

function enqueued(begin, onProgress) {
  count += 1;
  const id = `job-${count}`;
  const result = new Promise((resolve, reject) => {
    waiting.set(id, { begin, resolve, reject, onProgress });
  });
  if (current !== null) {
    onProgress(NaN, "waiting for other work …");
  }
  beginNext();
  return { id, result };
}

function beginNext() {
  if (current !== null || waiting.size === 0) {
    return;
  }
  const [id, { begin, onProgress }] = waiting.entries().next().value;
  current = id;
  onProgress(NaN, "computing …");
  begin(id).catch((error) => settle(id, "reject", error));
}

function cancel(id) {
  if (waiting.has(id)) {
    if (current === id && socket?.readyState === WebSocket.OPEN) {
      socket.send(JSON.stringify({ id, type: "cancel" }));
    }
    settle(id, "reject", new DOMException("cancelled", "AbortError"));
  }
}

function settle(id, how, value) {
  const entry = waiting.get(id);
  waiting.delete(id);
  if (current === id) {
    current = null;
  }
  entry?.[how](value);
  beginNext();
}

function opened() {
  if (socket?.readyState === WebSocket.OPEN) {
    return Promise.resolve(socket);
  }
  opening ??= new Promise((resolve, reject) => {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const fresh = new WebSocket(`${scheme}//${location.host}/api/jobs`);
    fresh.addEventListener("open", () => {
      socket = fresh;
      opening = null;
      noteConnection(true);
      resolve(fresh);
    });
    fresh.addEventListener("message", (event) => receive(JSON.parse(event.data)));
    fresh.addEventListener("close", () => {
      socket = null;
      opening = null;
      reject(new ServerGone());
      const lost = [...waiting.values()];
      waiting.clear();
      current = null;
      lost.forEach((entry) => entry.reject(new ServerGone()));
      isServerThere();
    });
  });
  return opening;
}

function receive(message) {
  if (message.type === "progress") {
    waiting.get(message.id)?.onProgress(message.share, message.text);
  } else if (message.type === "result") {
    settle(message.id, "resolve", message.result);
  } else if (message.type === "error") {
    const { message: words, faults, status } = message.error;
    if (status === BUSY) {
      tryAgain(message.id);
    } else {
      settle(message.id, "reject", new Refused(words, faults));
    }
  }
}

/** Ask once more in a moment; the job can be cancelled meanwhile. */
function tryAgain(id) {
  waiting.get(id)?.onProgress(NaN, "waiting for what other pages compute …");
  setTimeout(() => {
    if (waiting.has(id) && current === id) {
      waiting.get(id).begin(id).catch((error) => settle(id, "reject", error));
    }
  }, AGAIN_MS);
}
