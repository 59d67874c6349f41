// The peer "Babylon.js SSR": Babylon.js with its SSRRenderingPipeline. three-pass.mjs explains what a peer exports.

import { Engine } from '@babylonjs/core/Engines/engine.js';
import { Scene } from '@babylonjs/core/scene.js';
import { FreeCamera } from '@babylonjs/core/Cameras/freeCamera.js';
import { Vector3 } from '@babylonjs/core/Maths/math.vector.js';
import { Color3, Color4 } from '@babylonjs/core/Maths/math.color.js';
import { Mesh } from '@babylonjs/core/Meshes/mesh.js';
import { VertexData } from '@babylonjs/core/Meshes/mesh.vertexData.js';
import { PBRMaterial } from '@babylonjs/core/Materials/PBR/pbrMaterial.js';
import { SSRRenderingPipeline } from '@babylonjs/core/PostProcesses/RenderPipeline/Pipelines/ssrRenderingPipeline.js';
import '@babylonjs/core/Rendering/prePassRendererSceneComponent.js';
import '@babylonjs/core/Rendering/geometryBufferRendererSceneComponent.js';
import '@babylonjs/core/PostProcesses/RenderPipeline/postProcessRenderPipelineManagerSceneComponent.js';

export const title = 'Babylon.js SSR';
export const npm = '@babylonjs/core';

export const settings = {
    step: [1],
    maxSteps: [1000],
    maxDistance: [1000],
    thickness: [0.5, 0.02, 0.05, 0.1, 0.2],
    strength: [1],
    reflectionSpecularFalloffExponent: [1, 2],
    selfCollisionNumSkip: [1, 2],
    attenuateScreenBorders: [true, false],
    attenuateIntersectionDistance: [true, false],
    attenuateIntersectionIterations: [true, false],
    blurDispersionStrength: [0.03, 0],
    roughnessFactor: [0.2, 0],
    clipToFrustum: [true, false],
    enableAutomaticThicknessComputation: [false, true],
};

export async function render(canvas, scene, chosen) {
    canvas.width = scene.width;
    canvas.height = scene.height;
    const engine = new Engine(canvas, false, { preserveDrawingBuffer: true, antialias: false, adaptToDeviceRatio: false });
    const world = new Scene(engine);
    world.useRightHandedSystem = true;
    world.clearColor = new Color4(0, 0, 0, 1);
    world.imageProcessingConfiguration.toneMappingEnabled = false;
    const camera = new FreeCamera('camera', Vector3.FromArray(scene.eye), world);
    camera.setTarget(Vector3.FromArray(scene.lookAt));
    camera.fov = scene.fovY;
    camera.minZ = scene.near;
    camera.maxZ = scene.far;
    for (const name of new Set(scene.quads.map((q) => q.material))) {
        const own = scene.quads.filter((q) => q.material === name);
        const data = new VertexData();
        data.positions = own.flatMap((q) => q.corners.flat());
        data.normals = own.flatMap((q) => [q.normal, q.normal, q.normal, q.normal].flat());
        data.indices = own.flatMap((_, k) => [0, 2, 1, 0, 3, 2].map((i) => 4 * k + i));
        const mesh = new Mesh(name, world);
        data.applyToMesh(mesh);
        const material = new PBRMaterial(name, world);
        const [r, g, b] = own[0].color.map((v) => v / 255);
        material.albedoColor = new Color3(r, g, b).toLinearSpace();
        material.metallic = name === 'floor' ? 1 : 0;
        material.roughness = name === 'floor' ? scene.roughness : 1;
        material.unlit = name !== 'floor';
        material.backFaceCulling = false;
        mesh.material = material;
    }
    if (chosen !== null) {
        const pipeline = new SSRRenderingPipeline('ssr', world, [camera]);
        for (const [name, value] of Object.entries(chosen))
            pipeline[name] = value;
    }
    await world.whenReadyAsync();
    for (let frame = 0; frame < 3; ++frame)
        world.render();
    await new Promise((resolve) => setTimeout(resolve, 50));
    world.render();
}
