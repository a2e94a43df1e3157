// Models by three.js, Babylon.js and glTF Transform: node glass.mjs FOLDER
// A ball that disperses light, a block of coloured glass, a thin pane, a leaf, variants, hidden nodes.
import fs from "node:fs";
const [, , folder] = process.argv;
const COLOR = [0.9, 0.6, 0.3];
const LEAF = { factor: 0.75, color: [0.4, 0.8, 0.1] };

// What exporters take from browsers.
globalThis.FileReader = class {
    async readAsArrayBuffer(blob) {
        this.result = await blob.arrayBuffer();
        this.onloadend?.();
    }
    async readAsDataURL(blob) {
        const bytes = Buffer.from(await blob.arrayBuffer());
        this.result = `data:application/octet-stream;base64,${bytes.toString("base64")}`;
        this.onloadend?.();
    }
};

async function byThree() {
    const three = await import("three");
    const { GLTFExporter } = await import("three/examples/jsm/exporters/GLTFExporter.js");
    const glass = { transmission: 1, roughness: 0, metalness: 0 };
    const write = async (name, geometry, material) => {
        const scene = new three.Scene();
        scene.add(new three.Mesh(geometry, new three.MeshPhysicalMaterial(material)));
        const bytes = await new GLTFExporter().parseAsync(scene, { binary: true });
        fs.writeFileSync(`${folder}/three_${name}.glb`, Buffer.from(bytes));
    };
    const ball = new three.SphereGeometry(0.5, 192, 96);
    await write("ball", ball, { ...glass, thickness: 1, ior: 1.6, dispersion: 2 });
    await write("ball_usual", ball, { ...glass, thickness: 1, dispersion: 2 });
    const color = new three.Color().setRGB(...COLOR);
    const block = { thickness: 1, ior: 1.7, attenuationColor: color, attenuationDistance: 0.5 };
    await write("block", new three.BoxGeometry(1, 0.8, 1), { ...glass, ...block });
    await write("pane", new three.PlaneGeometry(1, 1).rotateX(-Math.PI / 2), { ...glass, ior: 1.7 });
}

async function byBabylon() {
    const core = await import("@babylonjs/core/index.js");
    const { GLTF2Export } = await import("@babylonjs/serializers/glTF/index.js");
    const engine = new core.NullEngine();
    const write = async (name, make, set) => {
        const scene = new core.Scene(engine);
        scene.useRightHandedSystem = true;
        const mesh = make(scene);
        const material = new core.PBRMaterial(name, scene);
        Object.assign(material, { metallic: 0, roughness: 0 });
        set(material);
        mesh.material = material;
        const files = (await GLTF2Export.GLBAsync(scene, name)).files ?? (await GLTF2Export.GLBAsync(scene, name)).glTFFiles;
        fs.writeFileSync(`${folder}/babylon_${name}.glb`, Buffer.from(await files[`${name}.glb`].arrayBuffer()));
        scene.dispose();
    };
    const refracts = (material, ior) => {
        material.subSurface.isRefractionEnabled = true;
        material.subSurface.refractionIntensity = 1;
        material.subSurface.indexOfRefraction = ior;
        material.subSurface.maximumThickness = 1;
        material.subSurface.useThicknessAsDepth = true;
    };
    await write("ball", (scene) => core.MeshBuilder.CreateSphere("ball", { diameter: 1, segments: 48 }, scene), (material) => {
        refracts(material, 1.6);
        material.subSurface.isDispersionEnabled = true;
        material.subSurface.dispersion = 2;
    });
    await write("block", (scene) => core.MeshBuilder.CreateBox("block", { width: 1, height: 0.8, depth: 1 }, scene), (material) => {
        refracts(material, 1.7);
        material.subSurface.tintColor = new core.Color3(...COLOR);
        material.subSurface.tintColorAtDistance = 0.5;
    });
    await write("leaf", (scene) => core.MeshBuilder.CreateGround("leaf", { width: 1, height: 1 }, scene), (material) => {
        material.subSurface.isTranslucencyEnabled = true;
        material.subSurface.translucencyIntensity = LEAF.factor;
        material.subSurface.translucencyColor = new core.Color3(...LEAF.color);
        material.subSurface.useAlbedoToTintTranslucency = false;
        material.subSurface.useGltfStyleTextures = true;
        material.subSurface.volumeIndexOfRefraction = 1;
        material.subSurface.maximumThickness = 0;
    });
}

async function byTransform() {
    const { Document, NodeIO } = await import("@gltf-transform/core");
    const of = await import("@gltf-transform/extensions");
    const io = new NodeIO().registerExtensions(of.ALL_EXTENSIONS);
    // A square of one metre at a height, facing up.
    const square = (document, height, material) => {
        const buffer = document.getRoot().listBuffers()[0] ?? document.createBuffer();
        const corners = [-0.5, height, -0.5, -0.5, height, 0.5, 0.5, height, 0.5, 0.5, height, -0.5];
        const accessor = (type, array) => document.createAccessor().setType(type).setArray(array).setBuffer(buffer);
        const primitive = document.createPrimitive()
            .setAttribute("POSITION", accessor("VEC3", new Float32Array(corners)))
            .setIndices(accessor("SCALAR", new Uint16Array([0, 1, 2, 0, 2, 3])))
            .setMaterial(material);
        return { primitive, node: document.createNode().setMesh(document.createMesh().addPrimitive(primitive)) };
    };
    const write = async (name, make) => {
        const document = new Document();
        const scene = document.createScene();
        make(document, scene);
        await io.write(`${folder}/transform_${name}.glb`, document);
    };
    await write("leaf", (document, scene) => {
        const leaf = document.createExtension(of.KHRMaterialsDiffuseTransmission).createDiffuseTransmission()
            .setDiffuseTransmissionFactor(LEAF.factor).setDiffuseTransmissionColorFactor(LEAF.color);
        const material = document.createMaterial().setDoubleSided(true).setMetallicFactor(0)
            .setExtension("KHR_materials_diffuse_transmission", leaf);
        scene.addChild(square(document, 0, material).node);
    });
    await write("pane", (document, scene) => {
        const clear = document.createExtension(of.KHRMaterialsTransmission).createTransmission().setTransmissionFactor(1);
        const index = document.createExtension(of.KHRMaterialsIOR).createIOR().setIOR(1.7);
        const material = document.createMaterial().setMetallicFactor(0).setRoughnessFactor(0)
            .setExtension("KHR_materials_transmission", clear).setExtension("KHR_materials_ior", index);
        scene.addChild(square(document, 0, material).node);
    });
    await write("variants", (document, scene) => {
        const colored = (color) => document.createMaterial().setAlphaMode("BLEND").setMetallicFactor(0)
            .setBaseColorFactor([...color, 0.5]).setDoubleSided(true);
        const [day, night] = [colored([1, 0.5, 0]), colored([0, 0.25, 1])];
        const extension = document.createExtension(of.KHRMaterialsVariants);
        const { primitive, node } = square(document, 0, day);
        const list = extension.createMappingList();
        for (const [name, material] of [["day", day], ["night", night]]) {
            list.addMapping(extension.createMapping().setMaterial(material).addVariant(extension.createVariant(name)));
        }
        primitive.setExtension("KHR_materials_variants", list);
        scene.addChild(node);
    });
    await write("hidden", (document, scene) => {
        const material = document.createMaterial().setDoubleSided(true);
        const visibility = document.createExtension(of.KHRNodeVisibility).createVisibility().setVisible(false);
        const above = square(document, 1, material).node;
        above.setExtension("KHR_node_visibility", visibility);
        scene.addChild(square(document, 0, material).node.setTranslation([0, 0, 0]));
        scene.addChild(above);
    });
}

for (const make of [byThree, byBabylon, byTransform]) {
    try {
        await make();
    } catch (error) {
        console.error(`${make.name}: ${error.stack}`);
        process.exitCode = 1;
    }
}
process.exit();
