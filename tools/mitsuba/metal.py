"""White metal as Umbrage has it.

GGX with Smith's shadowing for correlated heights, and what bounces between microfacets given back (Turquin 2019).
Mitsuba's own shadows light and view apart from each other and loses what bounces again.
"""

import mitsuba as mi
import numpy as np


def hidden(alpha, cosine):
    """Smith's Λ."""
    squared = np.clip(cosine * cosine, 1e-12, 1.0)
    return 0.5 * (np.sqrt(1 + alpha**2 * (1 - squared) / squared) - 1)


def unshadowed(alpha, view, light):
    """Of what facets that are seen reflect, the part that leaves."""
    return (1 + hidden(alpha, view)) / (1 + hidden(alpha, view) + hidden(alpha, light))


def albedo(alpha, cosine, side=256):
    """What a single bounce reflects, by the mean over visible normals (Heitz 2018)."""
    first, second = np.meshgrid(*[(np.arange(side) + 0.5) / side] * 2)
    stretched = np.array([alpha * np.sqrt(1 - cosine**2), 0, cosine])
    stretched /= np.linalg.norm(stretched)
    turn, height = 2 * np.pi * first, (1 - second) * (1 + stretched[2]) - stretched[2]
    across = np.sqrt(np.clip(1 - height**2, 0, None))
    facet = np.stack([across * np.cos(turn), across * np.sin(turn), height], -1) + stretched
    facet *= [alpha, alpha, 1]
    facet /= np.linalg.norm(facet, axis=-1, keepdims=True)
    view = np.array([np.sqrt(1 - cosine**2), 0, cosine])
    light = 2 * (facet @ view) * facet[..., 2] - cosine
    return np.where(light > 0, unshadowed(alpha, cosine, np.clip(light, 1e-6, 1)), 0).mean()


class WhiteMetal(mi.BSDF):
    """Plug-in `white_metal` with the GGX width `alpha`."""

    def __init__(self, properties):
        super().__init__(properties)
        self.alpha = properties["alpha"]
        self.distribution = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha)
        self.cosines = np.linspace(0.02, 1, 50)
        self.again = [1 / albedo(self.alpha, cosine) for cosine in self.cosines]
        self.m_components = [mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide]
        self.m_flags = self.m_components[0]

    def scattered_again(self, cosine):
        return np.interp(cosine, self.cosines, self.again)

    def sample(self, context, interaction, sample1, sample2, active=True):
        view = interaction.wi
        found, black = mi.BSDFSample3f(), mi.Color3f(0.0)
        if view.z <= 0:
            return found, black
        facet, density = self.distribution.sample(view, sample2)
        light = mi.reflect(view, facet)
        if density <= 0 or light.z <= 0:
            return found, black
        found.wo, found.eta, found.sampled_component = light, 1.0, 0
        found.pdf = density / (4 * abs(np.dot(view, facet)))
        found.sampled_type = self.m_flags
        return found, mi.Color3f(unshadowed(self.alpha, view.z, light.z) * self.scattered_again(view.z))

    def eval(self, context, interaction, light, active=True):
        view = interaction.wi
        if view.z <= 0 or light.z <= 0:
            return mi.Color3f(0.0)
        facet = np.array(view) + np.array(light)
        facet /= np.linalg.norm(facet)
        shadowed = 1 / (1 + hidden(self.alpha, view.z) + hidden(self.alpha, light.z))
        lobe = self.distribution.eval(mi.Vector3f(*facet)) * shadowed / (4 * view.z)
        return mi.Color3f(lobe * self.scattered_again(view.z))

    def pdf(self, context, interaction, light, active=True):
        view = interaction.wi
        if view.z <= 0 or light.z <= 0:
            return 0.0
        facet = np.array(view) + np.array(light)
        facet = mi.Vector3f(*(facet / np.linalg.norm(facet)))
        return self.distribution.pdf(view, facet) / (4 * abs(np.dot(view, facet)))

    def eval_pdf(self, context, interaction, light, active=True):
        return self.eval(context, interaction, light), self.pdf(context, interaction, light)


def register():
    mi.register_bsdf("white_metal", WhiteMetal)
