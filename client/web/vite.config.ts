import { defineConfig } from 'vitest/config';

// The page of a running server, for `npm run dev`.
const server = process.env.MOTIONDB_URL ?? 'http://127.0.0.1:8080';

export default defineConfig({
  build: {
    target: 'es2022',
    // The content security policy allows no data: URLs.
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 1200,
    sourcemap: false,
  },
  server: {
    proxy: {
      '^/(motiondb\\.v1\\.|login|logout|session)': server,
    },
  },
  test: {
    environment: 'jsdom',
    // One document for all files: to make one for each takes most of the time.
    isolate: false,
    testTimeout: 30_000, // of a busy machine; the longest test takes 1.5 s
    include: ['src/**/*.test.ts'],
  },
});
