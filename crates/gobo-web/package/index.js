// gobo-shadows: `await Gobo.create()`, and the element <gobo-view>.
import { Canvas, Gobo as Opened } from "./gobo_web.js";
import { GoboView, load } from "./view.js";

/** Shadow maps on a WebGPU device of its own. */
export class Gobo {
    /** Loads the program and opens a device; see `Gobo.create` of gobo_web.d.ts. */
    static async create(tier) {
        await load();
        return Opened.create(tier);
    }
}

export { Canvas, GoboView };
