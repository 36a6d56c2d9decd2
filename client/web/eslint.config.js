import { dirname } from 'node:path';
import { fileURLToPath } from 'node:url';

import js from '@eslint/js';
import globals from 'globals';
import typescript from 'typescript-eslint';

// Sinks that interpret a string as HTML or code: names and labels are shown as text only.
const htmlSinks = ['innerHTML', 'outerHTML', 'srcdoc'].map((name) => ({
  selector: `AssignmentExpression[left.property.name='${name}']`,
  message: `Expected textContent or elements, got ${name}: text must never become HTML.`,
}));
const htmlCalls = ['insertAdjacentHTML', 'setHTMLUnsafe', 'createContextualFragment', 'html'].map(
  (name) => ({
    selector: `CallExpression[callee.property.name='${name}']`,
    message: `Expected textContent or elements, got ${name}(): text must never become HTML.`,
  }),
);

export default typescript.config(
  { ignores: ['dist', 'src/generated'] },
  js.configs.recommended,
  {
    files: ['src/**/*.ts'],
    extends: [typescript.configs.strictTypeChecked],
    languageOptions: {
      globals: globals.browser,
      parserOptions: {
        project: './tsconfig.json',
        tsconfigRootDir: dirname(fileURLToPath(import.meta.url)),
      },
    },
    rules: {
      eqeqeq: 'error',
      'no-console': 'error',
      // Arrays of numbers are read by index in loops that stay inside them.
      '@typescript-eslint/no-non-null-assertion': 'off',
      'no-eval': 'error',
      'no-implied-eval': 'error',
      'no-restricted-syntax': ['error', ...htmlSinks, ...htmlCalls],
      '@typescript-eslint/restrict-template-expressions': ['error', { allowNumber: true }],
    },
  },
  {
    files: ['scripts/**/*.mjs', '*.js', '*.ts'],
    extends: [typescript.configs.disableTypeChecked],
    languageOptions: { globals: globals.node },
  },
  {
    // Parts of the browser tests run in the page.
    files: ['tests/**/*.mjs'],
    languageOptions: { globals: { ...globals.node, ...globals.browser } },
    rules: { eqeqeq: 'error' },
  },
);
