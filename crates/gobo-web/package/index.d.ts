import { Canvas, Gobo as Opened } from "./gobo_web.js";
export type { MapView, Maps } from "./gobo_web.js";
export { Canvas };

/** Shadow maps on a WebGPU device of its own. */
export type Gobo = Opened;
export declare const Gobo: {
    /** Loads the program and opens a device, of the tier `subgroups` if supported, else of `core`. */
    create(tier?: "core" | "subgroups"): Promise<Opened>;
};

/** `<gobo-view src=".." poster=".." moving=".." tier="core" still>`: a scene that can be turned. */
export declare class GoboView extends HTMLElement {
    /** Shows files: a scene and the files that it names. */
    open(files: Iterable<File>): Promise<void>;
    /** The `Gobo` that it shows, once it runs. */
    readonly gobo: Opened | undefined;
}

declare global {
    interface HTMLElementTagNameMap {
        "gobo-view": GoboView;
    }
    interface HTMLElementEventMap {
        "gobo-open": CustomEvent<{ name: string; contents: string }>;
        "gobo-frame": CustomEvent<{ ms: number; withMaps: boolean }>;
        "gobo-error": CustomEvent<{ message: string }>;
        "gobo-lost": CustomEvent<{ message: string }>;
    }
}
