// The operator's stop. It goes as a request of its own, which waits behind nothing that the channels say, again and again until
// the program answers; over the channels it goes besides, where they are there.

const AGAIN_MS = 700;
const ANSWER_MS = 3000;
/** After so long whoever watches has to stop the robot in another way (ms). */
const TELL_MS = 4000;

export class OperatorStop {
  /** What the button says. */
  onWord: (word: "Stop" | "Stopping" | "Not stopped") => void = () => {};
  /** Over the channels. */
  onCall: () => void = () => {};
  onNote: (level: "info" | "error", text: string) => void = () => {};
  private pressed = 0; // which press counts; a later one, or another run, ends the one before

  constructor(private url: string) {}

  /** Another run has begun: what was pressed for the last one is over. */
  reset(): void {
    this.pressed++;
    this.onWord("Stop");
  }

  async press(): Promise<void> {
    const mine = ++this.pressed, since_ms = performance.now();
    this.onWord("Stopping");
    this.onCall();
    for (let told = false; mine === this.pressed;) {
      try {
        const answer = await fetch(this.url, { method: "POST", cache: "no-store", keepalive: true, signal: AbortSignal.timeout(ANSWER_MS) });
        if (mine !== this.pressed) return;
        if (answer.ok) return this.onNote("info", "the program has taken the stop");
        this.onNote("error", `the program refuses the stop: ${await answer.text()}`);
        return this.onWord("Stop");
      } catch {
        if (!told && performance.now() - since_ms > TELL_MS) {
          told = true;
          this.onNote("error", "the stop has not reached the program: use the robot's own stop");
          this.onWord("Not stopped");
        }
      }
      await new Promise((again) => setTimeout(again, AGAIN_MS));
    }
  }
}
