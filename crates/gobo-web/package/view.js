// <gobo-view>: a scene on a canvas that the visitor can turn. Attributes: `src`, the address of a file;
// `poster`, a picture shown at once; `moving`, an animated one for browsers without WebGPU; `tier`, `core`
// for no better one; `still`, so that the sun does not move by itself.
import init, { Canvas, Gobo } from "./gobo_web.js";

/** Largest file that is read [bytes]. */
const LARGEST_FILE = 512 * 2 ** 20;
const ANGLE = 0.08; // of a key [radians]
const NO_WEBGPU =
    "This browser has no WebGPU, which the shadows need: what you see is a film of them. " +
    "Chrome and Edge 113, Safari 26 and Firefox 141 or newer have it.";

const STYLE = `
:host { display: grid; grid-template-rows: minmax(0, 1fr) auto; position: relative; min-height: 12rem;
    background: #14161a; color: #f2f2f4; font: 1rem/1.4 system-ui, sans-serif; }
.scene { position: relative; min-height: 0; overflow: hidden; }
canvas, .poster { position: absolute; inset: 0; width: 100%; height: 100%; display: block; }
.poster { object-fit: cover; }
canvas { touch-action: none; cursor: grab; }
canvas:focus-visible, button:focus-visible, input:focus-visible, select:focus-visible, label:focus-within {
    outline: 3px solid #ffd54a; outline-offset: 2px; }
canvas:focus-visible { outline-offset: -3px; }
.over { position: absolute; left: 0; right: 0; bottom: 0; padding: .6rem .8rem; background: #14161ae6; }
.over:empty, [hidden] { display: none !important; }
.error { white-space: pre-wrap; background: #5b1116; font: .95rem/1.4 ui-monospace, monospace; max-height: 60%;
    overflow: auto; }
.tools { display: flex; flex-wrap: wrap; gap: .4rem 1.1rem; align-items: center; padding: .6rem .8rem; }
.tools label { display: inline-flex; gap: .5rem; align-items: center; min-height: 2.5rem; }
button, select, .file { font: inherit; color: inherit; background: #2c3038; border: 1px solid #8b919d; border-radius: .3rem;
    padding: .4rem .7rem; min-height: 2.5rem; cursor: pointer; }
.file input { position: absolute; opacity: 0; width: 1px; height: 1px; }
input[type=range] { width: 9rem; accent-color: #ffd54a; min-height: 2.5rem; }
input[type=checkbox] { width: 1.3rem; height: 1.3rem; accent-color: #ffd54a; }
progress { width: 100%; accent-color: #ffd54a; }
output { font-variant-numeric: tabular-nums; min-width: 18em; }
.dropping { outline: 4px dashed #ffd54a; outline-offset: -8px; }
`;

const BODY = `
<div class="scene">
  <canvas tabindex="0" role="application" aria-label="Scene. Arrow keys turn the camera, with Shift the sun; plus and minus
zoom, C changes how shadows are read, Home goes back to the first view."></canvas>
  <img class="poster" alt="">
  <div class="over status" role="status"></div>
  <div class="over error" role="alert" hidden></div>
</div>
<div class="tools" role="group" aria-label="Scene">
  <label class="file"><span>Open a file</span><input type="file" multiple></label>
  <button type="button" class="glass">Stained glass</button>
  <label>Sun around <input type="range" class="around" min="-180" max="180" step="1" value="0"></label>
  <label>Sun up <input type="range" class="up" min="-60" max="60" step="1" value="0"></label>
  <label><input type="checkbox" class="moves"> Sun moves</label>
  <label>Shadows by <select class="curve"><option value="curve">curve</option>
    <option value="nearest">nearest depth</option></select></label>
  <output aria-label="Time of a frame"></output>
</div>
`;

let module;
/** Loads the program once. */
export const load = () => (module ??= init());

const soon = (ms) => new Promise((done) => setTimeout(done, ms));

/** A device; while its GPU process starts, a browser has none for seconds. */
async function opened(tier) {
    for (let tries = 0; tries < 8; tries++) {
        try {
            return await Gobo.create(tier);
        } catch {
            await soon(250 * 2 ** Math.min(tries, 3));
        }
    }
    return undefined;
}

/** The files of a drop or a choice, by name. Nothing is sent anywhere. */
async function contentsOf(files) {
    const contents = {};
    for (const file of files) {
        if (file.size > LARGEST_FILE) {
            throw new Error(`${file.name}: has ${Math.round(file.size / 2 ** 20)} MiB\n  help: a page reads files of up to ` +
                `${LARGEST_FILE / 2 ** 20} MiB; the program reads larger ones`);
        }
        contents[file.webkitRelativePath || file.name] = new Uint8Array(await file.arrayBuffer());
    }
    return contents;
}

export class GoboView extends HTMLElement {
    static observedAttributes = ["src"];

    #files = [];
    #gobo;
    #canvas;
    #run = 0;
    #dirty = true;
    #camera = { turn: 0, lift: 0, zoom: 1 };
    #sun = { turn: 0, lift: 0 };
    #pointers = new Map();
    #scale = 1;
    #texels = 512;
    #restarts = 0;
    #sizes;
    #parts;

    constructor() {
        super();
        const root = this.attachShadow({ mode: "open" });
        const style = document.createElement("style");
        style.textContent = STYLE;
        const body = document.createElement("template");
        body.innerHTML = BODY;
        root.append(style, body.content);
        const part = (name) => root.querySelector(name);
        this.#parts = {
            scene: part(".scene"), canvas: part("canvas"), poster: part(".poster"), status: part(".status"),
            error: part(".error"), file: part(".file input"), glass: part(".glass"), around: part(".around"),
            up: part(".up"), moves: part(".moves"), curve: part(".curve"), time: part("output"),
        };
        this.#listen();
    }

    connectedCallback() {
        const { poster, moves } = this.#parts;
        poster.src = this.getAttribute("poster") ?? "";
        poster.hidden = !this.hasAttribute("poster");
        const isCalm = matchMedia("(prefers-reduced-motion: reduce)").matches;
        moves.checked = !this.hasAttribute("still") && !this.hasAttribute("src") && !isCalm;
        this.#sizes = new ResizeObserver(() => (this.#dirty = true));
        this.#sizes.observe(this.#parts.scene);
        this.#start();
    }

    disconnectedCallback() {
        this.#sizes?.disconnect();
        this.#stop();
    }

    attributeChangedCallback(_name, before, after) {
        if (before !== null && after !== before && this.isConnected) {
            this.#files = [];
            this.#start();
        }
    }

    /** Shows files: one that is a scene, with those that it names. */
    async open(files) {
        this.#files = [...files];
        await this.#start();
    }

    /** The `Gobo` that it shows, once it runs. */
    get gobo() {
        return this.#gobo;
    }

    #say(text, made, all) {
        const { status } = this.#parts;
        status.textContent = text;
        if (all) {
            const bar = document.createElement("progress");
            Object.assign(bar, { value: made, max: all });
            bar.setAttribute("aria-label", "Kernels made");
            status.append(bar);
        }
    }

    #fail(error) {
        const { error: place } = this.#parts;
        const isMemory = error instanceof WebAssembly.RuntimeError || error instanceof RangeError;
        const text = isMemory
            ? "the page has not enough memory for this\n  help: reload the page, and use the program for such a file"
            : String(error?.message ?? error);
        place.textContent = `error: ${text}`;
        place.hidden = false;
        this.#say("");
        this.dispatchEvent(new CustomEvent("gobo-error", { detail: { message: text } }));
    }

    #stop() {
        this.#run += 1;
        this.#canvas?.free();
        this.#gobo?.free();
        this.#canvas = this.#gobo = undefined;
    }

    async #start() {
        this.#stop();
        const run = this.#run;
        this.#parts.error.hidden = true;
        this.#parts.time.textContent = "";
        this.#camera = { turn: 0, lift: 0, zoom: 1 };
        this.#setSun(0, 0);
        try {
            if (!navigator.gpu) {
                return this.#withoutWebgpu();
            }
            this.#say("Loading…");
            await load();
            const gobo = await opened(this.getAttribute("tier") ?? undefined);
            if (run !== this.#run) {
                return gobo?.free();
            }
            if (!gobo) {
                return this.#withoutWebgpu();
            }
            this.#gobo = gobo;
            gobo.device.lost.then(({ message }) => run === this.#run && this.#lost(message));
            const name = await this.#read(gobo);
            if (run !== this.#run) {
                return;
            }
            this.#size();
            this.#canvas = new Canvas(gobo, this.#parts.canvas);
            this.#canvas.set_curve(this.#parts.curve.value === "curve");
            this.#canvas.set_most_texels(gobo, this.#texels);
            this.dispatchEvent(new CustomEvent("gobo-open", { detail: { name, contents: gobo.contents() } }));
            await this.#loop(run);
        } catch (error) {
            // After a lost device its requests fail, too: `#lost` opens another.
            await soon(500);
            if (run === this.#run) {
                // The former scene's picture is gone: no loop may go on drawing it.
                this.#run += 1;
                this.#fail(error);
            }
        }
    }

    async #read(gobo) {
        const src = this.getAttribute("src");
        if (!this.#files.length && !src) {
            gobo.stained_glass();
            return "stained glass";
        }
        this.#say("Reading…");
        await soon(0);
        if (this.#files.length) {
            return gobo.open(await contentsOf(this.#files));
        }
        const answer = await fetch(src);
        if (!answer.ok) {
            throw new Error(`${src}: ${answer.status} ${answer.statusText}\n  help: check the address`);
        }
        const name = decodeURIComponent(new URL(src, location.href).pathname.split("/").pop());
        return gobo.open(await contentsOf([new File([await answer.blob()], name)]));
    }

    #withoutWebgpu() {
        const { poster, canvas } = this.#parts;
        poster.hidden = false;
        poster.src = this.getAttribute("moving") ?? poster.src;
        canvas.hidden = true;
        this.shadowRoot.querySelector(".tools").hidden = true;
        this.#say(NO_WEBGPU);
        this.dispatchEvent(new CustomEvent("gobo-error", { detail: { message: NO_WEBGPU } }));
    }

    /** A device that is lost is opened again, some times. */
    #lost(message) {
        this.#restarts += 1;
        this.dispatchEvent(new CustomEvent("gobo-lost", { detail: { message } }));
        if (this.#restarts > 3) {
            return this.#fail(`the graphics device was lost: ${message}\n  help: reload the page`);
        }
        this.#start();
    }

    async #loop(run) {
        const { time, poster } = this.#parts;
        let isFirst = true;
        while (run === this.#run) {
            const [gobo, canvas] = [this.#gobo, this.#canvas];
            await new Promise(requestAnimationFrame);
            if (run !== this.#run) {
                return;
            }
            this.#moveSun();
            if (!this.#dirty) {
                continue;
            }
            this.#resize();
            canvas.set_camera(this.#camera.turn, this.#camera.lift, this.#camera.zoom);
            canvas.set_sun(this.#sun.turn, this.#sun.lift);
            const made = canvas.make(gobo);
            if (made) {
                this.#say(`Making kernels: ${made.made} of ${made.all} (${made.name})`, made.made, made.all);
                made.free();
                await gobo.device.queue.onSubmittedWorkDone();
                continue;
            }
            this.#dirty = false;
            const begin = performance.now();
            const withMaps = canvas.draw(gobo);
            await gobo.device.queue.onSubmittedWorkDone();
            if (run !== this.#run) {
                return;
            }
            const ms = performance.now() - begin;
            const fault = gobo.fault();
            if (fault) {
                throw new Error(fault);
            }
            time.textContent = `${ms.toFixed(1)} ms${withMaps ? " with shadows" : ""}, ${gobo.tier}`;
            if (isFirst) {
                isFirst = false;
                poster.hidden = true;
                this.#say("");
            } else if (withMaps) {
                this.#adapt(ms);
            }
            this.dispatchEvent(new CustomEvent("gobo-frame", { detail: { ms, withMaps } }));
        }
    }

    /** Fewer texels and pixels where a frame takes long, more where it does not. */
    #adapt(ms) {
        const [texels, scale] = ms > 60 ? [512, 0.5] : ms < 6 ? [2048, 1] : ms < 25 ? [1024, 1] : [this.#texels, this.#scale];
        if (texels !== this.#texels || scale !== this.#scale) {
            [this.#texels, this.#scale] = [texels, scale];
            this.#canvas.set_most_texels(this.#gobo, texels);
            this.#dirty = true;
        }
    }

    #size() {
        const { canvas, scene } = this.#parts;
        const box = scene.getBoundingClientRect();
        const scale = Math.min(devicePixelRatio, 2) * this.#scale;
        const edge = (length) => Math.max(1, Math.min(4096, Math.round(length * scale)));
        const size = [edge(box.width), edge(box.height)];
        const isNew = size[0] !== canvas.width || size[1] !== canvas.height;
        if (isNew) {
            // Any assignment clears the canvas.
            [canvas.width, canvas.height] = size;
        }
        return isNew;
    }

    /** Follows the size of the element, between frames. */
    #resize() {
        const { canvas } = this.#parts;
        if (this.#size()) {
            this.#canvas.resize(this.#gobo, canvas.width, canvas.height);
        }
    }

    #setSun(turn, lift) {
        this.#sun = { turn, lift };
        const degrees = (angle) => Math.round((angle * 180) / Math.PI);
        this.#parts.around.value = ((degrees(turn) + 540) % 360) - 180;
        this.#parts.up.value = degrees(lift);
        this.#dirty = true;
    }

    #moveSun() {
        if (this.#parts.moves.checked) {
            const angle = performance.now() / 6000;
            this.#setSun(0.5 * Math.sin(angle), 0.12 * Math.sin(0.7 * angle));
        }
    }

    #turn(aside, up) {
        this.#camera.turn += aside;
        this.#camera.lift = Math.max(-1.5, Math.min(1.5, this.#camera.lift + up));
        this.#dirty = true;
    }

    #zoom(factor) {
        this.#camera.zoom = Math.max(0.05, Math.min(20, this.#camera.zoom * factor));
        this.#dirty = true;
    }

    #turnSun(aside, up) {
        this.#parts.moves.checked = false;
        this.#setSun(this.#sun.turn + aside, Math.max(-1, Math.min(1, this.#sun.lift + up)));
    }

    #setCurve(curve) {
        this.#parts.curve.value = curve ? "curve" : "nearest";
        this.#canvas?.set_curve(curve);
        this.#dirty = true;
    }

    #key(event) {
        const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
        const arrow = arrows[event.key];
        if (arrow) {
            const [aside, up] = arrow.map((way) => way * ANGLE);
            event.shiftKey ? this.#turnSun(aside, up) : this.#turn(aside, up);
        } else if (event.key === "+" || event.key === "=") {
            this.#zoom(0.9);
        } else if (event.key === "-") {
            this.#zoom(1 / 0.9);
        } else if (event.key === "c" || event.key === "C") {
            this.#setCurve(this.#parts.curve.value !== "curve");
        } else if (event.key === "Home") {
            this.#camera = { turn: 0, lift: 0, zoom: 1 };
            this.#setSun(0, 0);
        } else {
            return;
        }
        event.preventDefault();
    }

    #move(event) {
        const before = this.#pointers.get(event.pointerId);
        if (!before) {
            return;
        }
        const others = [...this.#pointers].filter(([id]) => id !== event.pointerId);
        const [x, y] = [event.clientX - before.x, event.clientY - before.y];
        if (others.length) {
            // Two fingers: nearer or farther.
            const [, other] = others[0];
            const apart = (of) => Math.max(1, Math.hypot(of.x - other.x, of.y - other.y));
            this.#zoom(apart(before) / apart({ x: event.clientX, y: event.clientY }));
        } else if (event.shiftKey || (event.buttons & 2) !== 0) {
            this.#turnSun(x * 0.01, -y * 0.01);
        } else {
            this.#turn(-x * 0.008, y * 0.008);
        }
        this.#pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    }

    #listen() {
        const { canvas, scene, file, glass, around, up, curve } = this.#parts;
        canvas.addEventListener("keydown", (event) => this.#key(event));
        canvas.addEventListener("contextmenu", (event) => event.preventDefault());
        canvas.addEventListener("pointerdown", (event) => {
            this.#pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
            if (event.isTrusted) {
                canvas.setPointerCapture(event.pointerId);
            }
        });
        canvas.addEventListener("pointermove", (event) => this.#move(event));
        for (const end of ["pointerup", "pointercancel"]) {
            canvas.addEventListener(end, (event) => this.#pointers.delete(event.pointerId));
        }
        canvas.addEventListener("wheel", (event) => {
            event.preventDefault();
            this.#zoom(Math.exp(Math.max(-100, Math.min(100, event.deltaY)) * 0.002));
        }, { passive: false });
        const bySliders = () => {
            const radians = (slider) => (Number(slider.value) * Math.PI) / 180;
            this.#parts.moves.checked = false;
            this.#setSun(radians(around), radians(up));
        };
        around.addEventListener("input", bySliders);
        up.addEventListener("input", bySliders);
        curve.addEventListener("change", () => this.#setCurve(curve.value === "curve"));
        file.addEventListener("change", () => file.files.length && this.open(file.files));
        glass.addEventListener("click", () => {
            this.removeAttribute("src");
            this.open([]);
        });
        this.addEventListener("dragover", (event) => {
            event.preventDefault();
            scene.classList.add("dropping");
        });
        this.addEventListener("dragleave", () => scene.classList.remove("dropping"));
        this.addEventListener("drop", (event) => {
            event.preventDefault();
            scene.classList.remove("dropping");
            if (event.dataTransfer.files.length) {
                this.#parts.moves.checked = false;
                this.open(event.dataTransfer.files);
            }
        });
    }
}

customElements.define("gobo-view", GoboView);
