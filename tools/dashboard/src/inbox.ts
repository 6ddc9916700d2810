// What the channels have said and the page has not shown yet. To take a message in costs next to nothing, so that a page which
// draws slowly still empties its connection: the server's pings are answered, and what is shown is the newest, not what has been.

export interface Mail { topic: string; at: bigint; data: Uint8Array }

/** Of these each message counts; of all others only the newest (tools/live/board has the same rule). */
const EACH = ["/task/change", "/log", "/load"];
/** Of these so many wait at most: more than the server keeps for who comes late. */
const MOST = 4000;

export class Inbox {
  private newest = new Map<string, Mail>();
  private each: Mail[] = [];
  private taken = 0; // of each
  private turn = false;

  get empty(): boolean { return this.newest.size === 0 && this.each.length === this.taken; }

  put(mail: Mail): void {
    if (!EACH.includes(mail.topic)) {
      this.newest.set(mail.topic, mail); // in the place of the one that waits
      return;
    }
    this.each.push(mail);
    if (this.each.length - this.taken > MOST) this.taken++;
    if (this.taken > MOST) {
      this.each.splice(0, this.taken);
      this.taken = 0;
    }
  }

  /** In turn of both kinds, so that none keeps the other waiting: who comes late gets a minute of /load at once. */
  take(): Mail | null {
    this.turn = !this.turn;
    const has = this.taken < this.each.length;
    if (has && (this.turn || this.newest.size === 0)) return this.each[this.taken++] ?? null;
    for (const [topic, mail] of this.newest) {
      this.newest.delete(topic);
      return mail;
    }
    return null;
  }

  clear(): void {
    this.newest.clear();
    this.each = [];
    this.taken = 0;
  }
}
