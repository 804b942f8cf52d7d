// A thin client: starts `sjdsl lsp` for games, and runs the commands of `sjdsl` in a terminal.

const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

const COMMANDS = ["compile", "test", "render", "studio"];
let client;

function command() {
  return vscode.workspace.getConfiguration("sjdsl").get("path") || "sjdsl";
}

async function start() {
  const server = { command: command(), args: ["lsp"] };
  const options = { documentSelector: [{ language: "sj" }] };
  client = new LanguageClient("sjdsl", "sjdsl", server, options);
  try {
    await client.start();
  } catch (error) {
    vscode.window.showErrorMessage(
      `The language server did not start (${error.message}). Install it with: pip install 'sjdsl[editor]', or set sjdsl.path.`,
    );
  }
}

async function run(name) {
  const editor = vscode.window.activeTextEditor;
  if (!editor || editor.document.languageId !== "sj") {
    vscode.window.showWarningMessage("Open a game first: a file that ends with .sj.");
    return;
  }
  if (!(await editor.document.save())) {
    return;
  }
  // The file is an argument of its own: no shell reads it.
  const execution = new vscode.ProcessExecution(command(), [name, editor.document.fileName]);
  const task = new vscode.Task({ type: "sjdsl", name }, vscode.TaskScope.Workspace, name, "sjdsl", execution);
  await vscode.tasks.executeTask(task);
}

async function activate(context) {
  for (const name of COMMANDS) {
    context.subscriptions.push(vscode.commands.registerCommand(`sjdsl.${name}`, () => run(name)));
  }
  const restart = async () => {
    await deactivate();
    await start();
  };
  context.subscriptions.push(vscode.commands.registerCommand("sjdsl.restart", restart));
  await start();
}

async function deactivate() {
  if (client && client.needsStop()) {
    await client.stop();
  }
}

module.exports = { activate, deactivate };
