"""Names beside lines, where limits of the axes still follow the data."""

from matplotlib.figure import Figure

from sjdsl.render.plot_style import Label, name_lines


def test_a_name_stands_at_the_height_of_its_line_before_anything_is_drawn() -> None:
    axes = Figure().add_subplot()
    axes.plot([0, 1], [-50.0, 200.0])
    name_lines(axes, [Label("ours", 200.0, "black"), Label("published", -50.0, "black")])
    low, high = axes.get_ylim()
    heights = {text.get_text(): text.xy[1] for text in axes.texts}  # type: ignore[attr-defined]
    assert abs(heights["ours"] - (200 - low) / (high - low)) < 1e-6
    assert abs(heights["published"] - (-50 - low) / (high - low)) < 1e-6
