// What is asked of the server, and what is said where it does not answer.

/** The server did not answer. */
export class ServerGone extends Error {
  constructor() {
    super("The server does not answer. Curves still follow the sliders; start it again with the same command to get the rest.");
    this.name = "ServerGone";
  }
}

/** The server answered that something is wrong; `faults` say where. */
export class Refused extends Error {
  constructor(message, faults = []) {
    super(message);
    this.name = "Refused";
    this.faults = faults;
  }
}

const listeners = new Set();
let present = true;

/**
 * Call a function with true or false when the server comes or goes.
 * @param {function(boolean): void} listener
 */
export function onConnection(listener) {
  listeners.add(listener);
}

/**
 * Note that the server answered, or that it did not.
 * @param {boolean} answered
 */
export function noteConnection(answered) {
  if (answered !== present) {
    present = answered;
    listeners.forEach((listener) => listener(present));
  }
}

async function request(path, options) {
  let answer;
  try {
    answer = await fetch(path, options);
  } catch (error) {
    if (error.name === "AbortError") {
      throw error;
    }
    noteConnection(false);
    throw new ServerGone();
  }
  noteConnection(true);
  if (!answer.ok) {
    throw await refusal(answer);
  }
  return answer;
}

async function refusal(answer) {
  try {
    const { error } = await answer.json();
    return new Refused(error.message, error.faults ?? []);
  } catch {
    return new Refused(`The server answered ${answer.status}.`);
  }
}

function posted(content, signal) {
  return {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(content),
    signal,
  };
}

/** Ask for JSON. */
export async function ask(path, signal) {
  return (await request(path, { signal })).json();
}

/** Send JSON and get JSON. */
export async function send(path, content, signal) {
  return (await request(path, posted(content, signal))).json();
}

/** Send JSON and get a file: its bytes and its name. */
export async function sendForFile(path, content, fallback) {
  const answer = await request(path, posted(content));
  const said = /filename="?([^";]+)"?/.exec(answer.headers.get("Content-Disposition") ?? "");
  return { blob: await answer.blob(), name: said?.[1] ?? fallback };
}

/** Whether the server answers now. */
export async function isServerThere() {
  try {
    await request("/api/start", {});
    return true;
  } catch (error) {
    return error instanceof Refused;
  }
}
