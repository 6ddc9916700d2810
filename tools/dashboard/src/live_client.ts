// A client of Foxglove's WebSocket protocol, version 1, as far as the page needs it. It comes back by itself when the
// connection ends; the server then sends the newest message of every channel again.

import { Inbox } from "./inbox";

type Handler = (message: any, atNs: bigint) => void;
interface Channel { id: number; topic: string; encoding: string }

const MESSAGE_DATA = 1, SERVICE_RESPONSE = 3, SERVICE_CALL = 2;
const AGAIN_MS = 1000;
/** A link on which nothing has come for so long is asked whether it still is one (ms); it gets as long for the answer. */
const SILENT_MS = 5000;

export class LiveClient {
  onLink: (word: "connected" | "connecting" | "lost", operates: boolean) => void = () => {};
  onNote: (level: number, text: string) => void = () => {};
  onReset: () => void = () => {};
  onName: (name: string) => void = () => {};

  private handlers = new Map<string, Handler>();
  private topics = new Map<number, string>(); // subscription -> topic
  private socket: WebSocket | null = null;
  private services = new Map<string, number>();
  private calls = 0;
  private session = "";

  /** What the channels say is not shown meanwhile: the page plays a recording by itself. */
  muted = false;
  onMessage: (atNs: bigint) => void = () => {};

  on<T>(topic: string, handler: (message: T, atNs: bigint) => void): void {
    this.handlers.set(topic, handler as Handler);
  }

  /** Something has come, and waits for work(). */
  onMail: () => void = () => {};
  /** A message cannot be read. */
  onDamage: (topic: string) => void = () => {};
  private inbox = new Inbox();
  private heard_ms = 0;

  constructor(private probe: string) { setInterval(() => void this.listen(), SILENT_MS); }

  /** Shows what has come, for so long. True: there is more. */
  work(max_ms: number): boolean {
    for (const until = performance.now() + max_ms; performance.now() < until;) {
      const mail = this.inbox.take();
      if (!mail) break;
      try {
        this.hand(mail.topic, new TextDecoder().decode(mail.data), mail.at);
      } catch {
        this.onDamage(mail.topic);
      }
      this.onMessage(mail.at);
    }
    return !this.inbox.empty;
  }

  /** Shows a message, whoever has it. */
  hand(topic: string, text: string, atNs: bigint): void {
    this.handlers.get(topic)?.(JSON.parse(text), atNs);
  }

  /** Everything once more, as to somebody who comes late. */
  again(): void { this.lose(); }

  connect(url: string): void {
    this.onLink("connecting", false);
    const socket = new WebSocket(url, ["foxglove.sdk.v1", "foxglove.websocket.v1"]);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onmessage = (event) => {
      this.heard_ms = performance.now();
      if (typeof event.data === "string") this.text(JSON.parse(event.data));
      else this.binary(event.data as ArrayBuffer);
    };
    this.lose = () => {
      this.lose = () => {};
      socket.onmessage = socket.onclose = null;
      socket.close();
      this.onLink("lost", false);
      this.topics.clear();
      this.services.clear();
      setTimeout(() => this.connect(url), AGAIN_MS);
    };
    socket.onclose = () => this.lose();
  }

  private lose: () => void = () => {};

  /** A cable that was pulled ends no connection: where nothing is said, the server is asked for something small. */
  private async listen(): Promise<void> {
    if (this.socket?.readyState !== WebSocket.OPEN || performance.now() - this.heard_ms < SILENT_MS) return;
    const asked = this.socket;
    try {
      await fetch(this.probe, { method: "HEAD", cache: "no-store", signal: AbortSignal.timeout(SILENT_MS) });
    } catch {
      if (asked === this.socket) this.lose();
    }
  }

  /** Asks an operator's service; false: this connection only watches, or there is none. */
  call(service: string): boolean {
    const id = this.services.get(service);
    if (id === undefined || this.socket?.readyState !== WebSocket.OPEN) return false;
    const encoding = new TextEncoder().encode("json"), payload = new TextEncoder().encode("{}");
    const bytes = new Uint8Array(13 + encoding.length + payload.length);
    const view = new DataView(bytes.buffer);
    view.setUint8(0, SERVICE_CALL);
    view.setUint32(1, id, true);
    view.setUint32(5, ++this.calls, true);
    view.setUint32(9, encoding.length, true);
    bytes.set(encoding, 13);
    bytes.set(payload, 13 + encoding.length);
    this.socket.send(bytes);
    return true;
  }

  private text(message: any): void {
    if (message.op === "serverInfo") {
      // another program, or another run, on the same port: nothing of the old one holds
      if (this.session !== "" && this.session !== message.sessionId) {
        this.inbox.clear();
        this.onReset();
      }
      this.session = message.sessionId;
      this.onName(message.name);
      this.onLink("connected", false);
    } else if (message.op === "advertise") {
      const subscriptions = [];
      for (const channel of message.channels as Channel[])
        if (this.handlers.has(channel.topic) && channel.encoding === "json") {
          this.topics.set(channel.id, channel.topic);
          subscriptions.push({ id: channel.id, channelId: channel.id });
        }
      this.socket?.send(JSON.stringify({ op: "subscribe", subscriptions }));
    } else if (message.op === "advertiseServices") {
      for (const service of message.services) this.services.set(service.name, service.id);
      this.onLink("connected", this.services.has("/operator/stop"));
    } else if (message.op === "status") {
      this.onNote(message.level, message.message);
    } else if (message.op === "serviceCallFailure") {
      this.onNote(2, message.message);
    }
  }

  private binary(data: ArrayBuffer): void {
    const view = new DataView(data);
    const op = view.getUint8(0);
    if (op === MESSAGE_DATA) {
      const topic = this.topics.get(view.getUint32(1, true));
      if (topic === undefined || this.muted) return;
      this.inbox.put({ topic, at: view.getBigUint64(5, true), data: new Uint8Array(data, 13) });
      this.onMail();
    } else if (op === SERVICE_RESPONSE) {
      const length = view.getUint32(9, true);
      const answer = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 13 + length)));
      this.onNote(0, answer.what ?? "done");
    }
  }
}
