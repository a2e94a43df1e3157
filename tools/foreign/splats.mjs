// .ksplat by GaussianSplats3D, in its three levels of compression: node splats.mjs FILE.ply FOLDER
import fs from "node:fs";
globalThis.window = globalThis;
const { PlyParser, SplatBufferGenerator } = await import("@mkkellogg/gaussian-splats-3d");
const [, , source, folder] = process.argv;
const bytes = new Uint8Array(fs.readFileSync(source)).buffer;
for (const level of [0, 1, 2]) {
    const splats = PlyParser.parseToUncompressedSplatArray(bytes, 2);
    const written = SplatBufferGenerator.getStandardGenerator(0, level).generateFromUncompressedSplatArray(splats);
    fs.writeFileSync(`${folder}/level${level}.ksplat`, Buffer.from(written.bufferData));
}
