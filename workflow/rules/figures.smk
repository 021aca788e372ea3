# The eight figures of the paper: each a named target (fig1 … fig8) and file targets (paper_figs/fig1.png, …). The folder
# of a figure in camid.paper draws it.


rule fig1:
    input:
        image=rules.marker_image.output[0],
        working_copy=BIRTH_MARK,
    output:
        png=report(
            "paper_figs/fig1.png",
            caption="../report/fig1.rst",
            category="Imaging",
            labels={"figure": "1", "of": "the paper"},
        ),
        pdf="paper_figs/fig1.pdf",
        csv="paper_figs/fig1.csv",
    log:
        "results/logs/fig1.log",
    params:
        **calls("draw.py", "paper.fig1_marker_image.drawing.draw"),
    message:
        "Drawing: Exposed image of the fast marker and its trajectory (Fig. 1)."
    script:
        "../scripts/draw.py"


rule fig2:
    input:
        image=rules.marker_image.output[0],
        working_copy=BIRTH_MARK,
    output:
        png=report(
            "paper_figs/fig2.png",
            caption="../report/fig2.rst",
            category="Imaging",
            labels={"figure": "2", "of": "the paper"},
        ),
        pdf="paper_figs/fig2.pdf",
        csv="paper_figs/fig2.csv",
    log:
        "results/logs/fig2.log",
    params:
        **calls("draw.py", "paper.fig2_gradient_image.drawing.draw"),
        threshold=config["imaging"]["threshold"],
    message:
        "Drawing: Gradient image and centre of mass (Fig. 2)."
    script:
        "../scripts/draw.py"


rule fig3:
    input:
        trajectory=rules.marker_trajectory.output[0],
        working_copy=BIRTH_MARK,
    output:
        png=report(
            "paper_figs/fig3.png",
            caption="../report/fig3.rst",
            category="Imaging",
            labels={"figure": "3", "of": "the paper"},
        ),
        pdf="paper_figs/fig3.pdf",
        csv="paper_figs/fig3.csv",
    log:
        "results/logs/fig3.log",
    params:
        **calls("draw.py", "paper.fig3_marker_trajectory.drawing.draw"),
        frequency=config["imaging"]["slow_frequency"],
    message:
        "Drawing: Measured and modelled trajectories (Fig. 3)."
    script:
        "../scripts/draw.py"


rule fig4:
    input:
        working_copy=BIRTH_MARK,
    output:
        png=report(
            "paper_figs/fig4.png",
            caption="../report/fig4.rst",
            category="Models",
            labels={"figure": "4", "of": "the paper"},
        ),
        pdf="paper_figs/fig4.pdf",
        csv="paper_figs/fig4.csv",
    log:
        "results/logs/fig4.log",
    params:
        **calls("draw.py", "paper.fig4_first_version.drawing.draw"),
    message:
        "Drawing: Model #1, first version (Fig. 4)."
    script:
        "../scripts/draw.py"


rule fig5:
    input:
        working_copy=BIRTH_MARK,
    output:
        png=report(
            "paper_figs/fig5.png",
            caption="../report/fig5.rst",
            category="Models",
            labels={"figure": "5", "of": "the paper"},
        ),
        pdf="paper_figs/fig5.pdf",
        csv="paper_figs/fig5.csv",
    log:
        "results/logs/fig5.log",
    params:
        **calls("draw.py", "paper.fig5_second_version.drawing.draw"),
    message:
        "Drawing: Model #1, second version (Fig. 5)."
    script:
        "../scripts/draw.py"


rule fig6:
    input:
        responses=rules.camera_models.output[0],
        working_copy=BIRTH_MARK,
    output:
        png=report(
            "paper_figs/fig6.png",
            caption="../report/fig6.rst",
            category="Models",
            labels={"figure": "6", "of": "the paper"},
        ),
        pdf="paper_figs/fig6.pdf",
        csv="paper_figs/fig6.csv",
    log:
        "results/logs/fig6.log",
    params:
        **calls("draw.py", "paper.fig6_camera_models.drawing.draw"),
        period=config["camera_models"]["period"],
    message:
        "Drawing: Bode diagrams of the three models (Fig. 6)."
    script:
        "../scripts/draw.py"


rule fig7:
    input:
        estimates=rules.sampling_period.output[0],
        working_copy=BIRTH_MARK,
    output:
        png=report(
            "paper_figs/fig7.png",
            caption="../report/fig7.rst",
            category="Identification",
            labels={"figure": "7", "of": "the paper"},
        ),
        pdf="paper_figs/fig7.pdf",
        csv="paper_figs/fig7.csv",
    log:
        "results/logs/fig7.log",
    params:
        **calls("draw.py", "paper.fig7_sampling_period.drawing.draw"),
        natural_frequency=config["plant"]["natural_frequency"],
        cases={"camera": "camera", "held": "zoh", "noise": "camera-noise"},
    message:
        "Drawing: Errors against the sampling period (Fig. 7)."
    script:
        "../scripts/draw.py"


rule fig8:
    input:
        estimates=rules.neglected_mode.output[0],
        working_copy=BIRTH_MARK,
    output:
        png=report(
            "paper_figs/fig8.png",
            caption="../report/fig8.rst",
            category="Identification",
            labels={"figure": "8", "of": "the paper"},
        ),
        pdf="paper_figs/fig8.pdf",
        csv="paper_figs/fig8.csv",
    log:
        "results/logs/fig8.log",
    params:
        **calls("draw.py", "paper.fig8_neglected_mode.drawing.draw"),
        period=config["neglected_mode_sweep"]["period"],
    message:
        "Drawing: Errors due to a neglected mode (Fig. 8)."
    script:
        "../scripts/draw.py"
