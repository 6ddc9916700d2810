// When the page works: one turn after the other, each as long as it takes until its picture is out, and after a long one a rest.
// Without a graphics card a picture takes half a second, and a page that drew all the time would neither hear a click nor read
// its messages.

export interface Painter {
  /** Something of it has changed. */
  wants: (now_ms: number) => boolean;
  draw: (now_ms: number) => void;
  /** Whose pictures are ready later than draw() returns. */
  gl?: WebGL2RenderingContext;
}

/** A cheaper turn needs no rest (ms): two periods of a display, and a little. */
const CHEAP_MS = 40;
/** A dear turn is followed by a rest of so many times its cost. */
const REST = 2;
/** But no view waits longer than this (ms). */
const LONGEST_REST_MS = 1500;
/** How often a picture that takes long is asked whether it is ready (ms). */
const ASK_MS = 4;
/** And how often messages are taken in meanwhile (ms). */
const MEANWHILE_MS = 200;
/** Of a turn messages get at least so long (ms), and of a dear one this part: who comes late has a minute to catch up with. */
const WORK_MS = 25, WORK_PART = 0.25;
/** A lost graphics context never answers (ms). */
const GIVE_UP_MS = 5000;
/** A page that nobody sees draws nothing, but goes on reading (ms). */
const HIDDEN_MS = 500;

interface Entry { painter: Painter; cost_ms: number; rests_until_ms: number }

export class Pace {
  /** Before the drawing of each turn: takes in what has come, for so long. True: more waits. */
  work: (max_ms: number) => boolean = () => false;
  private entries: Entry[] = [];
  private planned = false;
  private busy = false;
  private more = false;
  private last_ms = 0; // of the last turn

  add(painter: Painter): void { this.entries.push({ painter, cost_ms: 0, rests_until_ms: 0 }); }

  /** Something has come or changed. */
  wake(): void {
    if (this.busy) this.more = true;
    else this.plan(0);
  }

  private plan(after_ms: number): void {
    if (this.planned) return;
    this.planned = true;
    const turn = () => {
      this.planned = false;
      this.turn(performance.now());
    };
    if (document.hidden) setTimeout(turn, Math.max(after_ms, HIDDEN_MS));
    else if (after_ms > 0) setTimeout(() => soon(turn), after_ms);
    else soon(turn);
  }

  private turn(now_ms: number): void {
    this.busy = true;
    const work = () => guarded(() => this.work(Math.max(WORK_MS, WORK_PART * this.last_ms)), false);
    this.more = work();
    let dearest: Entry | null = null, gl: WebGL2RenderingContext | undefined;
    for (const entry of document.hidden ? [] : this.entries) {
      if (now_ms < entry.rests_until_ms || !entry.painter.wants(now_ms)) continue;
      // one dear picture in a turn, so that each one's cost is known
      if (dearest && dearest.cost_ms + entry.cost_ms > CHEAP_MS) continue;
      guarded(() => entry.painter.draw(now_ms), undefined);
      gl ??= entry.painter.gl;
      if (!dearest || entry.cost_ms >= dearest.cost_ms) dearest = entry;
    }
    const out = () => soon(() => this.rest(now_ms, dearest));
    // words do not wait for the picture
    const meanwhile = () => { this.more = work() || this.more; };
    if (gl) whenReady(gl, meanwhile, out);
    else out();
  }

  /** The turn's picture is out. */
  private rest(began_ms: number, drawn: Entry | null): void {
    this.busy = false;
    const now_ms = performance.now(), cost_ms = now_ms - began_ms;
    this.last_ms = Math.min(cost_ms, LONGEST_REST_MS);
    const rest_ms = cost_ms <= CHEAP_MS ? 0 : Math.min(LONGEST_REST_MS, REST * cost_ms);
    if (drawn) {
      drawn.cost_ms = cost_ms;
      drawn.rests_until_ms = now_ms + rest_ms;
    }
    // words rest less: they are what one reads
    const turn_ms = drawn ? rest_ms / REST : rest_ms;
    if (this.more) return this.plan(turn_ms);
    let next_ms = Infinity;
    for (const { painter, rests_until_ms } of this.entries)
      if (painter.wants(now_ms)) next_ms = Math.min(next_ms, Math.max(turn_ms, rests_until_ms - now_ms));
    if (next_ms < Infinity) this.plan(next_ms);
  }
}

/** What fails in one view, or for one message, is reported and ends no turn. */
function guarded<T>(what: () => T, otherwise: T): T {
  try {
    return what();
  } catch (error) {
    reportError(error);
    return otherwise;
  }
}

/** Before the next picture of the screen; where the page is hidden meanwhile, a little later. */
function soon(then: () => void): void {
  let done = false;
  const once = () => {
    if (!done) {
      done = true;
      then();
    }
  };
  const unseen = () => {
    if (document.hidden) once();
    else if (!done) setTimeout(unseen, HIDDEN_MS);
  };
  requestAnimationFrame(once);
  setTimeout(unseen, HIDDEN_MS);
}

function whenReady(gl: WebGL2RenderingContext, meanwhile: () => void, then: () => void): void {
  const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0), since_ms = performance.now();
  let worked_ms = since_ms;
  gl.flush();
  const ask = () => {
    if (performance.now() - worked_ms > MEANWHILE_MS) {
      worked_ms = performance.now();
      meanwhile();
    }
    const waits = fence && !gl.isContextLost() && gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED;
    if (waits && performance.now() - since_ms < GIVE_UP_MS) return void setTimeout(ask, ASK_MS);
    if (fence) gl.deleteSync(fence);
    then();
  };
  setTimeout(ask, 0);
}
