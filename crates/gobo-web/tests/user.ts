import * as THREE from "three/webgpu";
import { Gobo, GoboView, type MapView, type Maps } from "gobo-shadows";
import "gobo-shadows/view.js";

async function maps(): Promise<number[]> {
    const gobo: Gobo = await Gobo.create("core");
    gobo.empty([-0.4, -1, -0.3]);
    const skipped: number = gobo.add_particles(new Float32Array(3), new Float32Array([1]), new Float32Array(4));
    gobo.add_triangles(new Float32Array(9), [0.6, 0.6, 0.6, 1], true);
    const found: Maps = gobo.maps(1024);
    const filter: GPUTexture = found.filter;
    const device: GPUDevice = gobo.device;
    const renderer = new THREE.WebGPURenderer({ device });
    await renderer.init();
    const map = new THREE.ExternalTexture(filter);
    const views: MapView[] = found.views;
    const picture: Uint8Array = await gobo.picture(64, 40);
    gobo.free();
    return [skipped, map.id, ...views.map((view) => view.size[0]), picture.length];
}

const view = document.querySelector("gobo-view");
view?.addEventListener("gobo-frame", (event) => console.log(event.detail.ms.toFixed(1), event.detail.withMaps));
const made: GoboView = document.createElement("gobo-view");
void made.open([new File([], "a.ply")]);
void made.gobo?.tier;
void maps();

// Wrong calls must be refused.
// @ts-expect-error no such tier
void Gobo.create("fast");
// @ts-expect-error maps are made by `create` alone
new Gobo();
// @ts-expect-error a number
void maps().then((it) => it.filter(1));
