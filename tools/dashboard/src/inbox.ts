// What the channels have said and the page has not shown yet. To take a message in costs next to nothing, so that a page which
// draws slowly still empties its connection: the server's pings are answered, and what is shown is the newest, not what has been.

export interface Mail { topic: string; at: bigint; data: Uint8Array }

/** Of these each message counts; of all others only the newest (tools/live/board has the same rule). */
const EACH = ["/task/change", "/log", "/load"];
/** Of one of these so many wait at most: more than the server keeps for who comes late. */
const MOST = 4000;

export class Inbox {
  private waiting = new Map<string, Mail>(); // in the order of coming
  private numbers = 0;

  get empty(): boolean { return this.waiting.size === 0; }

  put(mail: Mail): void {
    if (!EACH.includes(mail.topic)) {
      this.waiting.set(mail.topic, mail); // in the place of the one that waits
      return;
    }
    if (this.waiting.size > MOST)
      for (const key of this.waiting.keys()) {
        if (!key.includes("#")) continue;
        this.waiting.delete(key);
        break;
      }
    this.waiting.set(`${mail.topic}#${this.numbers++}`, mail);
  }

  /** The one that has waited longest. */
  take(): Mail | null {
    for (const [key, mail] of this.waiting) {
      this.waiting.delete(key);
      return mail;
    }
    return null;
  }

  clear(): void { this.waiting.clear(); }
}
