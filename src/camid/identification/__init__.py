"""Identification of a linear plant from recordings, exact through hold and sensor.

Start with :func:`camid.identification.estimate.estimate`: it looks for starts (``starts``, ``discrete_time_start``),
runs an iteration from each (``safeguarded``, ``srivc``, ``output_error``), and compares the optima that it reaches
(``optimum_search``, ``optimum_selection``).

==========================  ====================================================================================
``experiment``              one recording as numbers: input, output, acquisition, rows that are fitted
``structure``               what is looked for: degrees of numerator and denominator, and which coefficients are free
``predictor``               simulated output of a plant for all experiments, and its sensitivities
``factorisation``           the same in one compiled pass, reduced to the triangle of a QR factorisation
                            (``records``, ``companion_system``, ``least_squares``, ``variable_projection``)
``accuracy``                covariance, Cramér–Rao bound, and what engineers call a plant by
``likelihood_profile``      intervals where the covariance is no measure
``residual_analysis``       whether the residual is white and independent of the input (``residual_statistics``)
``declarations``            which other hold, sensor, exposure or latency would explain it (``declaration_search``)
``order_selection``         how many poles and zeros the recordings support
``from_recordings``         from files and a simulation to experiments
``identification``          the result: estimate, errors, warnings
==========================  ====================================================================================
"""
