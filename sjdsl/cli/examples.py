"""The examples in the help of each command: calls to copy."""

EXAMPLES = {
    "bench": (
        "sjdsl bench harvest_open --envs 1,128,1024",
        "sjdsl bench pd_arena --observation onehot --json speed.json",
    ),
    "check": ("sjdsl check my_game.sj", "sjdsl check coins --variant socialjax --strict"),
    "compile": ("sjdsl compile my_game.sj --check", "sjdsl compile my_game.sj --standalone"),
    "crossplay": (
        "sjdsl crossplay coins --policies runs/common runs/individual random",
        "sjdsl crossplay coins --slots runs/common,stay --episodes 100",
    ),
    "diff": ("sjdsl diff pd_arena --variants default socialjax", "sjdsl diff my_game.sj other.sj"),
    "doc": ("sjdsl doc clean_up", "sjdsl doc my_game.sj --variant lush -o my_game.md"),
    "dump": (
        "sjdsl dump my_game.sj --after ir",
        "sjdsl dump my_game.sj --after python --no-positions",
    ),
    "evaluate": (
        "sjdsl evaluate runs/coins@best --film coins.gif",
        "sjdsl evaluate cooperator --game coins --scenario all",
    ),
    "explain": ("sjdsl explain SJ401", "sjdsl explain SJ101"),
    "fmt": ("sjdsl fmt my_game.sj", "sjdsl fmt --check games"),
    "list": ("sjdsl list",),
    "lsp": ("sjdsl lsp",),
    "new": ("sjdsl new my_game", "sjdsl new --from clean_up my_clean_up"),
    "play": (
        "sjdsl play clean_up --agent 2",
        "sjdsl play my_game.sj --watch --others runs/mine --record first.json",
    ),
    "plot": (
        "sjdsl plot runs/coins",
        "sjdsl plot common=runs/a individual=runs/b -o curves.png --metric equality",
    ),
    "record": (
        "sjdsl record clean_up --episodes 100",
        "sjdsl record coins --policy runs/coins@best -o coins.npz",
    ),
    "render": (
        "sjdsl render clean_up -o clean_up.gif",
        "sjdsl render my_game.sj --policy runs/mine@best --steps 200 -o mine.html",
    ),
    "replay": ("sjdsl replay first.json", "sjdsl replay clean_up.npz --episode 7 -o seventh.gif"),
    "report": ("sjdsl report runs -o report", "sjdsl report report/data runs/more -o report_2"),
    "schelling": (
        "sjdsl schelling coins --cooperators cooperator --defectors defector",
        "sjdsl schelling coins --cooperators runs/common --defectors runs/individual",
    ),
    "studio": ("sjdsl studio my_game.sj", "sjdsl studio --port 9000 --no-browser"),
    "sweep": (
        "sjdsl sweep coins --axis reward=individual,common --run runs/rewards",
        "sjdsl sweep coins --axis svo_angle=45,90 --reward svo --run runs/svo",
    ),
    "test": ("sjdsl test my_game.sj", "sjdsl test clean_up --examples 1000 --strict"),
    "trace": (
        "sjdsl trace clean_up --steps 3",
        "sjdsl trace my_game.sj --actions 'forward, stay; zap, stay' --phase shoot",
    ),
    "train": (
        "sjdsl train coins --preset two_cores --reward common --run runs/coins",
        "sjdsl train --resume runs/coins",
    ),
}


def epilog(command: str) -> str:
    """Returns the end of a command's help: its examples.

    click keeps the line breaks of a paragraph that begins with \\b.
    """
    return "\b\nExamples:\n" + "\n".join(f"  {line}" for line in EXAMPLES[command])
