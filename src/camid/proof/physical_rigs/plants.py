"""Plants of the rigs as users write them: what stands below ``physical``, without the values of the constants."""

SPRING = {"transfer_function": {"numerator": ["1"], "denominator": ["mass", "damping", "stiffness"]}}
MOTOR = {
    "transfer_function": {
        "numerator": ["torque_constant/resistance"],
        "denominator": ["inertia", "friction + torque_constant^2/resistance", "0"],
    }
}
TWO_MASSES = {
    "state_space": {
        "state_matrix": [
            ["0", "1", "0", "0"],
            ["-stiffness/motor_mass", "-(damping + friction)/motor_mass", "stiffness/motor_mass", "damping/motor_mass"],
            ["0", "0", "0", "1"],
            ["stiffness/load_mass", "damping/load_mass", "-stiffness/load_mass", "-damping/load_mass"],
        ],
        "input_vector": ["0", "1/motor_mass", "0", "0"],
        "output_row": ["0", "0", "1", "0"],
    }
}
QUARTER_CAR = {
    "state_space": {
        "state_matrix": [
            ["0", "1", "0", "0"],
            ["-spring/body_mass", "-damper/body_mass", "spring/body_mass", "damper/body_mass"],
            ["0", "0", "0", "1"],
            ["spring/wheel_mass", "damper/wheel_mass", "-(spring + tyre)/wheel_mass", "-damper/wheel_mass"],
        ],
        "input_vector": ["0", "0", "0", "tyre/wheel_mass"],
        "output_row": ["1", "0", "-1", "0"],
    }
}
HEATER = {
    "state_space": {
        "state_matrix": [
            ["-transfer/heater_capacity", "transfer/heater_capacity"],
            ["transfer/plate_capacity", "-(transfer + loss)/plate_capacity"],
        ],
        "input_vector": ["1/heater_capacity", "0"],
        "output_row": ["0", "1"],
    }
}
PENDULUM = {
    "equations": {
        "states": {"angle": "speed", "speed": "(u - damping*speed - mass*gravity*length*sin(angle))/inertia"},
        "output": "angle",
    }
}
HARDENING = {
    "equations": {
        "states": {"x": "v", "v": "(u - damping*v - linear*x - cubic*x^3)/mass"},
        "output": "x",
        "input": "u",
        "start": {"x": 0.1},
    }
}
TANKS = {
    "equations": {
        "states": {
            "upper": "pump*u - upper_outflow*sqrt(upper)",
            "lower": "upper_outflow*sqrt(upper) - lower_outflow*sqrt(lower)",
        },
        "output": "lower",
        "start": {"upper": 0.3, "lower": 0.3},
    }
}
UNEQUAL_TANKS = {
    "equations": {
        "states": {
            "upper": "pump*u - upper_out*sqrt(upper)",
            "lower": "lower_in*sqrt(upper) - lower_out*sqrt(lower)",
        },
        "output": "lower",
        "start": {"upper": 0.3, "lower": 0.3},
    }
}
FLOAT = {
    "equations": {
        "states": {"heave": "speed", "speed": "(force - drag*speed*abs(speed) - buoyancy*heave)/mass"},
        "output": "heave",
        "input": "force",
    }
}
