// SPDX-License-Identifier: MIT
// Rules of style for all packages.

import eslint from "@eslint/js";
import tseslint from "typescript-eslint";

export default tseslint.config(
  { ignores: ["**/node_modules/", "**/dist/"] },
  eslint.configs.recommended,
  ...tseslint.configs.strict,
  { files: ["**/*.mjs", "**/*.js"], languageOptions: { globals: { process: "readonly", console: "readonly", URL: "readonly" } } },
  {
    rules: {
      "prefer-const": "error",
      eqeqeq: "error",
      "max-lines": ["error", 400],
      "@typescript-eslint/no-non-null-assertion": "off", // indices that loops keep in range
      "@typescript-eslint/consistent-type-imports": "error",
    },
  },
);
