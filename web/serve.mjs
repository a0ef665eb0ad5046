// Serves web/dist on this machine: `node web/serve.mjs [--port N]`. The browser test serves by it too.
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, join, normalize, sep } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const TYPES = {
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript; charset=utf-8",
  ".wasm": "application/wasm",
};

export const DIST = fileURLToPath(new URL("./dist", import.meta.url));

/** The file that an address means, or null where it means none of the folder's. */
function fileOf(address, folder, base) {
  try {
    const path = decodeURIComponent(new URL(address, "http://localhost").pathname);
    const file = normalize(join(folder, path.slice(base.length) || "index.html"));
    return path.startsWith(base) && file.startsWith(folder + sep) && !file.includes("\0") ? file : null;
  } catch {
    return null;
  }
}

/**
 * Serves the files of `folder` under the path `base` (`/`, `/some/where/`), brotli where the browser
 * takes it. Port 0 means any free one. Resolves to the server and the page's address.
 */
export function serve(folder, { port = 0, base = "/" } = {}) {
  const server = createServer(async (request, response) => {
    const answer = (status, headers, body) => {
      response.writeHead(status, { "Cache-Control": "no-cache", ...headers });
      response.end(request.method === "HEAD" ? undefined : body);
    };
    if (!["GET", "HEAD"].includes(request.method)) return answer(405, {}, "Only GET is served here.\n");
    const file = fileOf(request.url, folder, base);
    if (!file) return answer(404, {}, "Not found.\n");
    const headers = { "Content-Type": TYPES[extname(file)] ?? "application/octet-stream" };
    try {
      if (/\bbr\b/.test(request.headers["accept-encoding"] ?? "")) {
        const packed = await readFile(`${file}.br`).catch(() => null);
        if (packed) {
          return answer(200, { ...headers, "Content-Encoding": "br", Vary: "Accept-Encoding" }, packed);
        }
      }
      answer(200, headers, await readFile(file));
    } catch {
      answer(404, {}, "Not found.\n");
    }
  });
  return new Promise((resolve, reject) => {
    server.once("error", reject);
    server.listen(port, "localhost", () => {
      resolve({ server, url: `http://localhost:${server.address().port}${base}` });
    });
  });
}

function stop(sentence, status) {
  console.error(`web/serve.mjs: ${sentence}`);
  process.exit(status);
}

async function main(args) {
  const port = args.length === 0 ? 8080 : Number(args[0] === "--port" ? args[1] : NaN);
  if (args.length > 2 || !Number.isInteger(port) || port < 0 || port > 65535) {
    stop("usage: node web/serve.mjs [--port N], N from 0 (any free one) to 65535", 2);
  }
  await readFile(join(DIST, "index.html")).catch(() => stop("web/dist is not built: run ./dev web-build.", 1));
  const { url } = await serve(DIST, { port }).catch((error) =>
    stop(error.code === "EADDRINUSE" ? `port ${port} is taken: choose another with --port.` : error.message, 1),
  );
  console.log(`Ocularium is at ${url} (Ctrl-C stops it).`);
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) await main(process.argv.slice(2));
