import { defineConfig } from "vite";

// The server embeds dist/ and serves it at its root; relative addresses keep it movable.
export default defineConfig({
  base: "./",
  build: { target: "es2022", assetsInlineLimit: 0, modulePreload: { polyfill: false } },
});
