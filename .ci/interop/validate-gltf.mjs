// Checks generated scenes with the Khronos validator and with three.js's GLTFLoader.
//
// Usage: node validate-gltf.mjs CASES.json
// CASES.json: [{ "file", "count", "kind": "droplets" | "parcels", "form": "points" | "instances" }]
// Prints one line per file and a closing line; exits 1 if any file has an error, a warning, or another content.

import fs from 'node:fs';
import validator from 'gltf-validator';

// Browsers have it, Node does not; three.js names it when it reads a data: URI.
globalThis.ProgressEvent ??= class ProgressEvent extends Event {};
const { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');

// The validator does not know EXT_mesh_gpu_instancing, and so takes what only the extension uses for unused.
const INSTANCING_INFOS = new Set(['UNSUPPORTED_EXTENSION', 'UNUSED_OBJECT']);

async function validate(bytes, { file, form }) {
  const format = file.endsWith('.glb') ? 'glb' : 'gltf';
  const { issues } = await validator.validateBytes(bytes, { format, maxIssues: 20 });
  const infos = issues.messages.filter(
    ({ severity, code }) => severity >= 2 && !(form === 'instances' && INSTANCING_INFOS.has(code)),
  );
  const faults = issues.messages.filter(({ severity }) => severity < 2).concat(infos);
  return {
    counts: [issues.numErrors, issues.numWarnings, issues.numInfos, issues.numHints],
    faults: faults.map(({ code, message, pointer }) => `${code} at ${pointer}: ${message}`),
  };
}

// What a three.js program sees of the particles.
async function load(bytes, { count, kind, form }) {
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const gltf = await new GLTFLoader().parseAsync(buffer, '');
  const seen = { cameras: 0, lights: 0, particles: 0 };
  const faults = [];
  gltf.scene.traverse((object) => {
    if (object.isCamera) seen.cameras += 1;
    if (object.isDirectionalLight) seen.lights += 1;
    const found = form === 'points' ? object.isPoints : object.isInstancedMesh;
    if (!found) return;
    const attributes = object.geometry.attributes;
    seen.particles += form === 'points' ? attributes.position.count : object.count;
    const names = form === 'points' ? ['_radius'] : [];
    names.push(kind === 'parcels' ? '_droplet_count' : '_droplet_radius_um');
    for (const name of names) {
      const attribute = attributes[name] ?? attributes[name.toUpperCase()];
      if (attribute?.count !== count) faults.push(`three.js finds ${attribute?.count} values of ${name}, not ${count}`);
      else if (!attribute.array.every((value) => Number.isFinite(value) && value > 0)) faults.push(`${name} <= 0`);
    }
  });
  if (seen.particles !== count) faults.push(`three.js finds ${seen.particles} particles, not ${count}`);
  if (seen.cameras !== 1 || seen.lights !== 1) faults.push(`three.js finds ${seen.cameras} cameras, ${seen.lights} lights`);
  if (gltf.scene.userData.mie_cloud?.droplets === undefined) faults.push('three.js finds no extras.mie_cloud');
  return faults;
}

const cases = JSON.parse(fs.readFileSync(process.argv[2], 'utf8'));
let nBad = 0;
console.log('errors warnings infos hints  file');
for (const one of cases) {
  const bytes = new Uint8Array(fs.readFileSync(one.file));
  const { counts, faults } = await validate(bytes, one);
  faults.push(...(await load(bytes, one)));
  const [errors, warnings, infos, hints] = counts.map(String);
  const name = one.file.split('/').pop();
  console.log(`${errors.padStart(6)} ${warnings.padStart(8)} ${infos.padStart(5)} ${hints.padStart(5)}  ${name}`);
  faults.forEach((fault) => console.log(`    ${fault}`));
  if (faults.length > 0) nBad += 1;
}
console.log(
  nBad === 0
    ? `glTF: ${cases.length} files, 0 errors, 0 warnings; three.js loads all of them`
    : `glTF: ${nBad} of ${cases.length} files are at fault`,
);
process.exit(cases.length > 0 && nBad === 0 ? 0 : 1);
