import { defineConfig } from "vite";

// The folder is given by the build (tools/dashboard/CMakeLists.txt); beside the program the server looks for it.
export default defineConfig({
  base: "./",
  build: { outDir: process.env.COLIFT_PAGE ?? "dist", emptyOutDir: true, chunkSizeWarningLimit: 1200,
    rollupOptions: { input: ["index.html", "both.html"] } },
});
