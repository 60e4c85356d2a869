// Asks the Khronos glTF validator about files: node tests/validate_gltf.cjs FILE…
// Prints every error and warning; exits with 1 if there is any. The package is looked for in NODE_PATH.
const fs = require('fs');
const validator = require('gltf-validator');

const ERROR = 0, WARNING = 1;

async function judge(file) {
  const { issues, info } = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), { maxIssues: 0 });
  const bad = issues.messages.filter((m) => m.severity <= WARNING);
  for (const m of bad) {
    console.log(`${file}: ${m.severity === ERROR ? 'error' : 'warning'} ${m.code} at ${m.pointer ?? m.offset}: ${m.message}`);
  }
  console.log(`${file}: ${issues.numErrors} errors, ${issues.numWarnings} warnings, ${issues.numInfos} infos, ` +
    `${info.totalTriangleCount} triangles, ${(info.resources ?? []).filter((r) => r.image).length} images`);
  return bad.length;
}

(async () => {
  const files = process.argv.slice(2);
  let bad = files.length === 0 ? 1 : 0;
  for (const file of files) bad += await judge(file);
  process.exitCode = bad === 0 ? 0 : 1;
})();
