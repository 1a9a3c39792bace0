// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The Khronos validator on each named file: 1 where any has an error, or moves nothing.
import { readFileSync } from "node:fs";
import validator from "gltf-validator";

let failed = false;
for (const file of process.argv.slice(2)) {
  const bytes = new Uint8Array(readFileSync(file));
  const report = await validator.validateBytes(bytes, { uri: file, maxIssues: 20 }).catch((why) => ({
    issues: { numErrors: 1, numWarnings: 0, messages: [{ severity: 0, message: String(why) }] },
    info: {},
  }));
  const { issues, info } = report;
  const moves = (info?.animationCount ?? 0) > 0;
  console.log(
    `${file.replace(/.*\//, "")}: ${bytes.length} bytes, ${issues.numErrors} errors, ` +
      `${issues.numWarnings} warnings, ${info?.animationCount ?? 0} animations, ` +
      `${info?.drawCallCount ?? 0} draw calls, ${info?.totalTriangleCount ?? 0} triangles`,
  );
  for (const issue of issues.messages) {
    if (issue.severity <= 1) console.log(`  ${issue.code}: ${issue.message} ${issue.pointer ?? ""}`);
  }
  if (issues.numErrors > 0) failed = true;
  if (!moves) {
    console.log("  there is no animation in it");
    failed = true;
  }
}
process.exit(failed ? 1 : 0);
